#pragma once
/// `balanced`: old points of the window weigh together `rho` times what the fresh ones weigh, whatever their number,
/// and match only what was in the map before the window began. (HIS-2)

#include <cstdint>
#include <optional>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/history.hpp"

namespace aslio::plugins {

class BalancedHistory final : public HistoryPolicy {
 public:
  struct Params {
    double rho = 0.25;
    double cap = 2.0;
    HistoryCovariance covariance = HistoryCovariance::joseph;
    std::optional<double> age_taper = std::nullopt;
    double gate = 3.0;
    double max_residual = 0.1;
  };
  static void describe(config::Binder& b, Params& p);

  BalancedHistory(const Params& params, const BuildContext& context);

  /// Pre: history_begin never decreases from window to window (what lies before it is forgotten).
  HistorySelection select(const Window& window) override;
  /// min(1, rho N_fresh / N_history): the history as a whole weighs rho times the fresh points.
  double weight(std::size_t fresh_residuals, std::size_t history_residuals) const override;
  double gate(double sigma) const override { return params_.gate * sigma; }
  void commit(const Window& window, const Update& update) override;
  void reset() override;

 private:
  /// When the points of an update entered the map (if they did).
  struct UpdateEnd {
    std::uint32_t sequence = 0;
    TimeNs t = 0;
  };

  void forget(TimeNs until);
  std::size_t most(const Window& window) const;

  Params params_;
  std::vector<HistoryPoint> points_;  ///< in time order; those before head_ are forgotten
  std::size_t head_ = 0;
  std::vector<HistoryPoint> selected_;
  std::vector<UpdateEnd> ends_;     ///< in time order, of windows that may still be inside a later one
  std::uint32_t max_stamp_ = 0;     ///< newest update older than any window to come
  double matched_per_fresh_ = 1.0;  ///< points offered to matching per raw point, at the last update
};

}  // namespace aslio::plugins
