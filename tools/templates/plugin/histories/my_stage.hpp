#pragma once

#include <cstdint>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stages/history.hpp"

namespace my_plugin {

/// What are old points of the window worth? Here: each the same share of a fresh one, if it had a match at its own
/// update. The contract stands in aslio/stages/history.hpp.
class MyStage final : public aslio::HistoryPolicy {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    double share = 0.5;
    double gate = 3.0;
    std::int64_t max_points = 20000;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  aslio::HistorySelection select(const aslio::Window& window) override;
  double weight(std::size_t fresh_residuals, std::size_t history_residuals) const override;
  double gate(double sigma) const override { return gate_ * sigma; }
  void commit(const aslio::Window& window, const aslio::Update& update) override;
  /// What earlier updates put into the map stays there, so their ends are not forgotten.
  void reset() override { points_.clear(); }

 private:
  double share_, gate_;
  std::size_t max_points_;
  struct End {
    aslio::TimeNs t;
    std::uint32_t sequence;
  };
  std::vector<aslio::HistoryPoint> points_;  ///< inside the window, oldest first
  std::vector<End> ends_;                    ///< of the updates inside the window
  std::uint32_t admissible_ = 0;             ///< the last update before it
};

}  // namespace my_plugin
