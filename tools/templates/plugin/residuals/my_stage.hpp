#pragma once

#include <cstdint>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"

namespace my_plugin {

/// What does a match measure, and with which noise? Here: the distance from the plane through the nearest points of the
/// map. The contract stands in aslio/stages/residual.hpp.
class MyStage final : public aslio::Residual {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    std::int64_t k = 5;
    double max_distance = 1.0;
    double thickness = 0.05;
    double gate = 3.0;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  int rows_per_match() const override { return 1; }
  aslio::MapQuery query() const override;
  void fit(std::span<const aslio::Vec3> queries, const aslio::Neighbours& neighbours,
           std::span<aslio::Surface> out) override;
  void evaluate(std::span<const aslio::Vec3> world, std::span<const float> range,
                std::span<const aslio::Surface> surfaces, double sigma, std::span<aslio::ResidualRow> rows) override;

 private:
  aslio::Surface plane_of(const aslio::Vec3& query, const aslio::Neighbours& neighbours, std::size_t row) const;

  Params params_;
  aslio::exec::Executor& exec_;
};

}  // namespace my_plugin
