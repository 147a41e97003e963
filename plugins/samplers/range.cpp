#include "samplers/range.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"

namespace aslio::plugins {

void RangeSampler::describe(config::Binder& b, Params& p) {
  b.optional_real("min", p.min, "m", {.min = 0.0, .max = 1e4}, "= min_range of the sensor",
                  "nearest range that is kept");
  b.optional_real("max", p.max, "m", {.above = 0.0, .below = 1e5}, "= max_range of the sensor",
                  "farthest range that is kept");
  describe_uses(b, p.uses);
  b.require(!p.min || !p.max || *p.min < *p.max, "max", "must be greater than min");
}

RangeSampler::RangeSampler(const Params& params, const BuildContext& context) : uses_(use_mask(params.uses)) {
  const double min = params.min.value_or(context.sensor.min_range);
  const double max = params.max.value_or(context.sensor.max_range);
  if (min >= max) {
    throw ConfigError(fmt::format("sampler range: min {} m{} is not below max {} m{}: give both limits", min,
                                  params.min ? "" : " (the sensor's min_range)", max,
                                  params.max ? "" : " (the sensor's max_range)"));
  }
  min_squared_ = min * min;
  max_squared_ = max * max;
}

void RangeSampler::sample(SampleBatch& batch) {
  const auto cleared = static_cast<PointUses>(~uses_);
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    const TimedPoint& p = batch.raw[i];
    const double squared =
        static_cast<double>(p.x) * p.x + static_cast<double>(p.y) * p.y + static_cast<double>(p.z) * p.z;
    const bool inside = squared >= min_squared_ && squared <= max_squared_;
    if (!inside) batch.uses[i] = static_cast<PointUses>(batch.uses[i] & cleared);
  }
}

}  // namespace aslio::plugins
