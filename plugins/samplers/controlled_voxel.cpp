#include "samplers/controlled_voxel.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::plugins {

namespace {

constexpr double kShortestWindow = 1e-3;  // [s]; the count of a shorter one says nothing of a period

/// From `low` to `high` as x rises from 0 to 1.
double scheduled(double low, double high, double x) { return low + (high - low) * std::min(1.0, x); }

/// Time between the first and the last point that some of `uses` still wants [s].
double seconds_of(const SampleBatch& batch, PointUses uses) {
  TimeNs first = kTimeMax, last = kTimeMin;
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    if ((batch.uses[i] & uses) == 0) continue;
    first = std::min(first, batch.raw[i].t);
    last = std::max(last, batch.raw[i].t);
  }
  return first < last ? to_seconds(last - first) : 0.0;
}

}  // namespace

/// Short windows share a slot, so that the ring covers scale_periods however short they are.
void LeafController::remember(const VoxelCount& count) {
  if (slots_ > 0) {
    VoxelCount& last = seen_[(slots_ - 1) % kSlots];
    if (last.periods + count.periods <= params_.scale_periods / 32) {
      const double periods = last.periods + count.periods;
      last.range = (last.range * last.periods + count.range * count.periods) / periods;
      last.periods = periods;
      return;
    }
  }
  seen_[slots_++ % kSlots] = count;
}

/// Mean of the median ranges of the windows of the last `scale_periods`, by their length.
double LeafController::scale() const {
  double sum = 0, time = 0;
  const std::size_t known = std::min(slots_, kSlots);
  for (std::size_t back = 1; back <= known; ++back) {
    const VoxelCount& one = seen_[(slots_ - back) % kSlots];
    const double weight = std::min(one.periods, params_.scale_periods - time);
    if (!(weight > 0.0)) break;
    sum += weight * one.range;
    time += weight;
  }
  return time > 0.0 ? sum / time : 0.0;
}

/// eq. SMP-2.
double LeafController::set_point() const {
  const double open = std::clamp(scale() / params_.full_scale, 0.0, 1.0);
  return params_.min_points +
         (params_.max_points - params_.min_points) * (1.0 - std::pow(1.0 - open, params_.exponent));
}

/// eq. SMP-2.
void LeafController::observe(const VoxelCount& count) {
  remember(count);
  const double wanted = set_point(), error = count.per_period - wanted, change = error - error_.value_or(error);
  error_ = error;
  const double p_gain =
      scheduled(params_.p_gain_min, params_.p_gain_max, std::abs(error) / (params_.error_sensitivity * wanted));
  const double d_gain =
      scheduled(params_.d_gain_min, params_.d_gain_max, std::abs(change) / (params_.error_rate_sensitivity * wanted));
  const double share = std::min(1.0, count.periods);
  // Where surfaces would have the wanted points; a step beyond it would swing.
  const double farthest = std::abs(leaf_ * (std::sqrt(count.per_period / wanted) - 1.0));
  const double step = std::clamp(share * p_gain * error + d_gain * change, -share * farthest, share * farthest);
  leaf_ = std::clamp(leaf_ + step, params_.min_leaf, params_.max_leaf);
}

void ControlledVoxel::describe(config::Binder& b, Params& p) {
  LeafController::Params& c = p.control;
  b.real("leaf", c.leaf, "m", {.min = 0.01, .max = 100.0}, "edge of a cube in the first window");
  b.real("min_leaf", c.min_leaf, "m", {.min = 0.01, .max = 100.0}, "shortest edge");
  b.real("max_leaf", c.max_leaf, "m", {.min = 0.01, .max = 100.0}, "longest edge");
  b.require(c.min_leaf <= c.leaf && c.leaf <= c.max_leaf, "leaf", "must lie from min_leaf to max_leaf");
  b.real("period", p.period, "s", {.min = 0.01, .max = 10.0},
         "data to which the points and gains belong. A window of another length is counted by its share of it");
  b.real("min_points", c.min_points, "", {.min = 10, .max = 1e6}, "points for one period in the narrowest scene");
  b.real("max_points", c.max_points, "", {.min = 10, .max = 1e6}, "points for one period in an open scene");
  b.require(c.min_points <= c.max_points, "min_points", "must not exceed max_points");
  b.real("full_scale", c.full_scale, "m", {.above = 0.0, .max = 1e4},
         "scale of the scene (mean of median ranges) from which on it is open");
  b.real("exponent", c.exponent, "", {.min = 1.0, .max = 10.0},
         "how fast the points wanted rise with the scale: 1 - (1 - scale / full_scale)^exponent");
  b.real("scale_periods", c.scale_periods, "", {.above = 0.0, .max = 100.0}, "periods over which the scale is a mean");
  b.real("p_gain_min", c.p_gain_min, "m", {.min = 0.0, .max = 1.0}, "edge per point too many, at the set-point");
  b.real("p_gain_max", c.p_gain_max, "m", {.min = 0.0, .max = 1.0}, "the same far from it");
  b.require(c.p_gain_min <= c.p_gain_max, "p_gain_min", "must not exceed p_gain_max");
  b.real("d_gain_min", c.d_gain_min, "m", {.min = 0.0, .max = 1.0}, "edge per change of that error, at no change");
  b.real("d_gain_max", c.d_gain_max, "m", {.min = 0.0, .max = 1.0}, "the same at a great change");
  b.require(c.d_gain_min <= c.d_gain_max, "d_gain_min", "must not exceed d_gain_max");
  b.real("error_sensitivity", c.error_sensitivity, "", {.min = 1e-3, .max = 1e3},
         "error, as a share of the points wanted, from which on p_gain_max holds");
  b.real("error_rate_sensitivity", c.error_rate_sensitivity, "", {.min = 1e-3, .max = 1e3},
         "change of the error, as a share of the points wanted, from which on d_gain_max holds");
  b.choice("keep", p.keep,
           {{"centre", VoxelSampler::Keep::centre},
            {"first", VoxelSampler::Keep::first},
            {"mean", VoxelSampler::Keep::mean}},
           "which point of a cube stays, as in voxel");
  describe_uses(b, p.uses);
}

ControlledVoxel::ControlledVoxel(const Params& params, const BuildContext& context)
    : controller_(params.control),
      period_(params.period),
      uses_(use_mask(params.uses)),
      filter_({.leaf = params.control.leaf, .keep = params.keep, .uses = params.uses}, context) {}

void ControlledVoxel::sample(SampleBatch& batch) {
  const double seconds = seconds_of(batch, uses_);
  filter_.set_leaf(controller_.leaf());
  filter_.sample(batch);
  if (const auto left = count(batch, seconds)) controller_.observe(*left);
}

std::optional<VoxelCount> ControlledVoxel::count(const SampleBatch& batch, double seconds) {
  if (seconds < kShortestWindow) return std::nullopt;
  if (ranges_.capacity() < batch.raw.size()) ranges_.reserve(2 * batch.raw.size());
  ranges_.clear();
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    if ((batch.uses[i] & uses_) == 0) continue;
    const TimedPoint& p = batch.raw[i];
    const float range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    if (std::isfinite(range)) ranges_.push_back(range);
  }
  if (ranges_.empty()) return std::nullopt;
  const auto middle = ranges_.begin() + static_cast<std::ptrdiff_t>(ranges_.size() / 2);
  std::nth_element(ranges_.begin(), middle, ranges_.end());
  const double periods = seconds / period_;
  return VoxelCount{.periods = periods,
                    .per_period = static_cast<double>(ranges_.size()) / periods,
                    .range = static_cast<double>(*middle)};
}

}  // namespace aslio::plugins
