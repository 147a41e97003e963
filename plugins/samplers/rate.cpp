#include "samplers/rate.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

void RateSampler::describe(config::Binder& b, Params& p) {
  b.real("points_per_s", p.points_per_s, "1/s", {.min = 1.0, .max = 1e9},
         "points of a second of the stream that stay; all of a sensor with fewer");
  describe_uses(b, p.uses);
}

RateSampler::RateSampler(const Params& params, const BuildContext& context)
    : points_per_s_(params.points_per_s), seed_(kGoldenRatio * context.order_seed), uses_(use_mask(params.uses)) {}

void RateSampler::begin_second(const TimedPoint& first) {
  Second next{.begin = first.t, .index = first.index, .keep_below = kKeepAll};
  const Second& last = seconds_.front();
  if (last.begin != kTimeMin) {
    // The difference of indices is right also where the count of the stream has passed 2^32.
    const double points = static_cast<std::uint32_t>(first.index - last.index);
    const double share = points_per_s_ * to_seconds(first.t - last.begin) / points;
    if (share < 1.0) next.keep_below = static_cast<std::uint64_t>(std::ldexp(share, 64));
  }
  std::shift_right(seconds_.begin(), seconds_.end(), 1);
  seconds_.front() = next;
}

std::uint64_t RateSampler::keep_below(TimeNs t) const {
  for (const Second& second : seconds_) {
    if (t >= second.begin) return second.keep_below;
  }
  return seconds_.back().keep_below;
}

void RateSampler::sample(SampleBatch& batch) {
  const auto cleared = static_cast<PointUses>(~uses_);
  TimeNs t = kTimeMin;
  std::uint64_t below = kKeepAll;
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    const TimedPoint& p = batch.raw[i];
    const TimeNs begin = seconds_.front().begin;
    if (begin == kTimeMin || p.t - begin >= kSecond) begin_second(p);
    if (p.t != t) below = keep_below(t = p.t);
    if (below != kKeepAll && mixed(p.index + seed_) >= below) {
      batch.uses[i] = static_cast<PointUses>(batch.uses[i] & cleared);
    }
  }
}

}  // namespace aslio::plugins
