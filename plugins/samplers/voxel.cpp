#include "samplers/voxel.hpp"

#include <array>
#include <bit>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

namespace {

constexpr float kFarthestCell = 1 << 20;

/// floor() without a call into the C library (baseline x86-64 has no instruction for it).
std::int32_t floor_to_int(float x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

/// Distance along one axis from the centre of the cell, in leaves.
float from_centre(float x, std::int32_t cell) { return x - (static_cast<float>(cell) + 0.5f); }

void clear(PointUses& uses, PointUses bits) { uses = static_cast<PointUses>(uses & ~bits); }

}  // namespace

void VoxelSampler::describe(config::Binder& b, Params& p) {
  b.real("leaf", p.leaf, "m", {.min = 0.01, .max = 100.0}, "edge of a cube");
  b.choice("keep", p.keep, {{"centre", Keep::centre}, {"first", Keep::first}, {"mean", Keep::mean}},
           "which point of a cube stays: the nearest to its centre, the first in time, or the nearest moved to the "
           "mean of all. The last is not for estimators that take points as measured");
  b.choice("of", p.of, {{"all", Of::all}, {"line", Of::line}, {"plane", Of::plane}},
           "which points are thinned: all, or those that a sampler has classed as lines, or planes");
  describe_uses(b, p.uses);
}

VoxelSampler::VoxelSampler(const Params& params, const BuildContext&)
    : leaves_per_metre_(static_cast<float>(1.0 / params.leaf)),
      keep_(params.keep),
      of_(params.of),
      uses_(use_mask(params.uses)) {}

void VoxelSampler::sample(SampleBatch& batch) {
  PointUses any = 0;
  auto all = uses_;
  for (std::size_t i = 0; i < batch.uses.size(); ++i) {
    const auto own = static_cast<PointUses>(batch.uses[i] & uses_);
    if (own == 0 || !concerns(batch, i)) continue;
    any = static_cast<PointUses>(any | own);
    all = static_cast<PointUses>(all & own);
  }
  if (any == 0) return;
  moves_.clear();
  // Usually every point left has the same uses and one competition decides for all of them.
  if (any == all) {
    compete(batch, any);
  } else {
    for (const PointUse use : {PointUse::overlap, PointUse::map, PointUse::match}) {
      if ((any & mask(use)) != 0) compete(batch, mask(use));
    }
  }
  for (const Move& move : moves_) batch.body[move.point] = move.to;
}

void VoxelSampler::start_pass(std::size_t points) {
  const std::size_t wanted = std::bit_ceil(points + points / 2 + 1);  // at least a third free, if no two share a cube
  if (slots_.size() < wanted) slots_.resize(2 * wanted);              // the next larger frame needs no memory
  if (keep_ == Keep::mean && sums_.size() < slots_.size()) {
    sums_.resize(slots_.size());
    moves_.reserve(3 * slots_.size());
  }
  shift_ = 64 - std::countr_zero(wanted);
  if (++pass_ == 0) {
    for (Slot& slot : slots_) slot.pass = 0;
    pass_ = 1;
  }
}

// `inline` for speed, as in voxel_plane.cpp: asked for every point.
inline bool VoxelSampler::concerns(const SampleBatch& batch, std::size_t i) const {
  if (of_ == Of::all) return true;
  const std::uint8_t own = batch.features.empty() ? batch.raw[i].feature : batch.features[i];
  return (own & ~feature_class::clearest) == (of_ == Of::line ? feature_class::line : feature_class::plane);
}

inline bool VoxelSampler::enlist(SampleBatch& batch, PointUses uses, std::size_t i, Candidate& candidate) const {
  if ((batch.uses[i] & uses) == 0 || !concerns(batch, i)) return false;
  const Eigen::Vector3f p = batch.body[i] * leaves_per_metre_;
  if (!(p.cwiseAbs().maxCoeff() < kFarthestCell) || !p.allFinite()) {
    clear(batch.uses[i], uses);
    return false;
  }
  const std::int32_t x = floor_to_int(p.x()), y = floor_to_int(p.y()), z = floor_to_int(p.z());
  constexpr std::uint64_t kCoordinate = (1U << 21) - 1;
  candidate.key = ((static_cast<std::uint64_t>(x) & kCoordinate) << 42) |
                  ((static_cast<std::uint64_t>(y) & kCoordinate) << 21) | (static_cast<std::uint64_t>(z) & kCoordinate);
  const float dx = from_centre(p.x(), x), dy = from_centre(p.y(), y), dz = from_centre(p.z(), z);
  const bool clear_one = !batch.features.empty() && (batch.features[i] & feature_class::clearest) != 0;
  candidate.squared = clear_one ? -1.0f : keep_ == Keep::first ? 0.0f : dx * dx + dy * dy + dz * dz;
  candidate.from_centre = Eigen::Vector3f(dx, dy, dz);
  candidate.at = ((candidate.key ^ (candidate.key >> 32)) * kGoldenRatio) >> shift_;
  candidate.point = static_cast<std::uint32_t>(i);
  return true;
}

inline void VoxelSampler::challenge(SampleBatch& batch, PointUses uses, const Candidate& candidate) {
  const std::size_t last = (std::size_t{1} << (64 - shift_)) - 1;
  std::size_t at = candidate.at;
  while (slots_[at].pass == pass_ && slots_[at].key != candidate.key) at = (at + 1) & last;
  Slot& slot = slots_[at];
  if (slot.pass != pass_) {
    slot = {candidate.key, pass_, candidate.point, candidate.squared};
    if (keep_ == Keep::mean) sums_[at] = {};
  }
  if (keep_ == Keep::mean) {
    sums_[at].points += 1.0f;
    sums_[at].distances += candidate.from_centre;
  }
  if (slot.holder == candidate.point) return;
  if (candidate.squared < slot.squared) {
    clear(batch.uses[slot.holder], uses);
    slot.holder = candidate.point;
    slot.squared = candidate.squared;
  } else {
    clear(batch.uses[candidate.point], uses);
  }
}

void VoxelSampler::compete(SampleBatch& batch, PointUses uses) {
  start_pass(batch.uses.size());
  // By the dozen, so that slots are on their way while others are computed: most of the time was spent waiting for
  // them.
  std::array<Candidate, 32> candidates;
  for (std::size_t i = 0; i < batch.uses.size();) {
    std::size_t count = 0;
    for (; i < batch.uses.size() && count < candidates.size(); ++i) {
      if (!enlist(batch, uses, i, candidates[count])) continue;
      __builtin_prefetch(&slots_[candidates[count].at], 1);
      ++count;
    }
    for (std::size_t c = 0; c < count; ++c) challenge(batch, uses, candidates[c]);
  }
  if (keep_ == Keep::mean) find_means(batch);
}

void VoxelSampler::find_means(const SampleBatch& batch) {
  const std::size_t slots = std::size_t{1} << (64 - shift_);
  for (std::size_t at = 0; at < slots; ++at) {
    const Slot& slot = slots_[at];
    if (slot.pass != pass_) continue;
    const Eigen::Vector3f& p = batch.body[slot.holder];
    const Eigen::Vector3f q = p * leaves_per_metre_;
    const Eigen::Vector3f own(from_centre(q.x(), floor_to_int(q.x())), from_centre(q.y(), floor_to_int(q.y())),
                              from_centre(q.z(), floor_to_int(q.z())));
    moves_.push_back({slot.holder, p + (sums_[at].distances / sums_[at].points - own) / leaves_per_metre_});
  }
}

}  // namespace aslio::plugins
