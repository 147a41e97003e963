#include "insertions/spaced_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

void SpacedPoints::begin(std::size_t most) {
  if (taken_.capacity() < most) {
    taken_.reserve(2 * most);
    next_.reserve(2 * most);
    first_.reserve(std::bit_ceil(4 * most));
  }
  taken_.clear();
  next_.clear();
  first_.assign(std::bit_ceil(2 * most + 1), kNone);
}

std::size_t SpacedPoints::bucket(std::int64_t x, std::int64_t y, std::int64_t z) const {
  std::uint64_t h = static_cast<std::uint64_t>(x) * kGoldenRatio;
  h = (h ^ (h >> 29) ^ static_cast<std::uint64_t>(y)) * 0xbf58476d1ce4e5b9U;
  h = (h ^ (h >> 32) ^ static_cast<std::uint64_t>(z)) * 0x94d049bb133111ebU;
  return static_cast<std::size_t>(h ^ (h >> 31)) & (first_.size() - 1);
}

bool SpacedPoints::near_one_of(std::size_t bucket, const Vec3& p) const {
  // Points of other cells may share the bucket: they are told by their distance too.
  for (std::uint32_t i = first_[bucket]; i != kNone; i = next_[i]) {
    if ((taken_[i].p_W - p).squaredNorm() < spacing_ * spacing_) return true;
  }
  return false;
}

void SpacedPoints::offer(const WorldPoint& point) {
  // Cells of twice the spacing: whatever is too near lies in the cell or, per axis, in the one on the nearer side.
  const Vec3 scaled = point.p_W / (2.0 * spacing_);
  constexpr double most = 1e15;
  if (!scaled.allFinite() || scaled.cwiseAbs().maxCoeff() >= most) return;  // maxCoeff() may pass over a NaN
  std::array<std::int64_t, 3> cell{}, side{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double s = scaled[static_cast<Eigen::Index>(axis)], floor = std::floor(s);
    cell[axis] = static_cast<std::int64_t>(floor);
    side[axis] = cell[axis] + (s - floor < 0.5 ? -1 : 1);
  }
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto of = [&](unsigned axis) { return (corner >> axis & 1U) != 0 ? side[axis] : cell[axis]; };
    if (near_one_of(bucket(of(0), of(1), of(2)), point.p_W)) return;
  }
  std::uint32_t& first = first_[bucket(cell[0], cell[1], cell[2])];
  next_.push_back(first);
  first = static_cast<std::uint32_t>(taken_.size());
  taken_.push_back(point);
}

}  // namespace aslio::plugins
