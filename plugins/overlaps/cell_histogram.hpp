#pragma once
/// The distinct cells of a frame and how many of its points lie in each.

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// Reused from frame to frame; allocates only while frames grow.
class CellHistogram {
 public:
  /// floor(p / voxel); false for a point that is not finite or whose cell is not within +-2^20.
  static bool cell_of(const Vec3& p, double inverse_voxel, Cell& out) {
    constexpr double limit = 1 << 20;  // what a store can hold per axis
    const double x = std::floor(p.x() * inverse_voxel), y = std::floor(p.y() * inverse_voxel),
                 z = std::floor(p.z() * inverse_voxel);
    const auto fits = [](double c) { return c >= -limit && c < limit; };  // false for NaN
    if (!fits(x) || !fits(y) || !fits(z)) return false;
    out = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)};
    return true;
  }

  /// Empties it and makes room for `points` points.
  void reset(std::size_t points);
  void add(const Cell& cell);
  /// In order of first appearance.
  std::span<const Cell> cells() const { return cells_; }
  std::span<const std::uint32_t> counts() const { return counts_; }
  std::size_t memory_bytes() const;

 private:
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> counts_;
  std::vector<std::uint32_t> slots_;  // number of a cell + 1; 0: empty
  unsigned shift_ = 64;
};

}  // namespace aslio::plugins
