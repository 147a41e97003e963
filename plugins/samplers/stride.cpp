#include "samplers/stride.hpp"

#include <numeric>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

void StrideSampler::describe(config::Binder& b, Params& p) {
  b.integer("keep_every", p.keep_every, "", {.min = 1, .max = 1e6}, "one in so many points (or firings) is kept");
  b.choice("by", p.by, {{"point", By::point}, {"firing", By::firing}},
           "count points over the stream, or keep a share of whole firings (points of equal time)");
  b.real("known", p.known, "", {.min = 0.0, .max = 1.0},
         "thin only after an update whose overlap degree is at least this, and whose view lacked nothing; 0: always");
  b.real("warmup", p.warmup, "s", {.min = 0.0, .max = 1000.0},
         "with known: time after the first insertion into the map for which all points are taken");
  describe_uses(b, p.uses);
}

StrideSampler::StrideSampler(const Params& params, const BuildContext& context)
    : keep_every_(static_cast<std::uint32_t>(params.keep_every)),
      phase_(static_cast<std::uint32_t>(context.order_seed % keep_every_)),
      seed_(context.order_seed),
      by_(params.by),
      known_(params.known),
      warmup_(to_ns(params.warmup)),
      thins_(params.known == 0.0),
      uses_(use_mask(params.uses)) {
  const auto lines = static_cast<std::uint32_t>(context.sensor.scan_lines);
  const std::uint32_t common = std::gcd(keep_every_, lines);
  if (by_ == By::point && common > 1 && context.log) {
    context.log->warn(
        "sampler stride: keep_every {} and the sensor's {} interleaved scan lines share the factor {}: only {} of the "
        "lines are ever kept. Use a stride without common factor, or by: firing",
        keep_every_, lines, common, lines / common);
  }
}

bool StrideSampler::keeps(const TimedPoint& p) const {
  if (by_ == By::point) return p.index % keep_every_ == phase_;
  return mixed(static_cast<std::uint64_t>(p.t) + kGoldenRatio * seed_) % keep_every_ == 0;
}

void StrideSampler::observe(const Feedback& feedback) {
  if (known_ == 0.0) return;
  // eq. SMP-1. Few matches, or a direction that is left open, are no reason to look at fewer points.
  thins_ = feedback.status == UpdateStatus::ok && feedback.overlap.value && *feedback.overlap.value >= known_ &&
           feedback.first_insertion != kTimeMax && feedback.t - feedback.first_insertion >= warmup_;
}

void StrideSampler::sample(SampleBatch& batch) {
  if (!thins_) return;
  const auto cleared = static_cast<PointUses>(~uses_);
  const TimedPoint* decided = nullptr;  // the last point that was
  bool kept = false;
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    if ((batch.uses[i] & uses_) == 0) continue;
    const TimedPoint& p = batch.raw[i];
    const bool same_firing = by_ == By::firing && decided != nullptr && decided->t == p.t;
    if (!same_firing) kept = keeps(p);
    decided = &p;
    if (!kept) batch.uses[i] = static_cast<PointUses>(batch.uses[i] & cleared);
  }
}

}  // namespace aslio::plugins
