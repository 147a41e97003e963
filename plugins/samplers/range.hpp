#pragma once
/// `range`: returns from the carrier, and those too far to be accurate, take no part.

#include <optional>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

namespace aslio::plugins {

class RangeSampler final : public Sampler {
 public:
  struct Params {
    std::optional<double> min = std::nullopt;
    std::optional<double> max = std::nullopt;
    UseNames uses{"overlap", "map", "match"};
  };
  static void describe(config::Binder& b, Params& p);

  /// Throws ConfigError when a limit contradicts the sensor's other limit.
  RangeSampler(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::raw; }
  void sample(SampleBatch& batch) override;

 private:
  double min_squared_, max_squared_;  ///< [m^2]
  PointUses uses_;
};

}  // namespace aslio::plugins
