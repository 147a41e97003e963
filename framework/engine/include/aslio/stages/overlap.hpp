#pragma once
/// Overlaps: how much of the frame does the map already know? (AS-LIO eqs. 1-6; docs/equations.md SOD-1..)

#include <cstdint>
#include <span>

#include "aslio/stages/points.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

/// Contract. evaluate() scores points in the world frame against the occupancy as it stood `delay` before the middle of
/// their time, which is from the last extend() to `t`, so that the score does not depend on how much time that is (of
/// frames no longer than `delay`; against longer ones it may be down to 3/4 `delay`, eq. SOD-3). It is called after
/// alignment and BEFORE extend() of the same points (overlap measured after the merge is always ~1). Undefined (no
/// value) while that occupancy is empty or with fewer than the metric's minimum of points; non-finite points are not
/// counted. Invariants: 0 <= O <= 1, sum(layers) <= points, and O = 1 iff every point is at layer 0. evaluate() does
/// not change any later score. Not thread-safe. No allocation in evaluate() after warm-up.
class OverlapMetric : public Stage {
 public:
  static constexpr std::string_view family = "overlaps";
  /// Score of the points of a window that ends at `t`.
  virtual OverlapScore evaluate(std::span<const WorldPoint> points, TimeNs t) = 0;
  /// The caller promises that no later call has an earlier time than `t`, so that what waits for `t` may be merged for
  /// good. Changes no score.
  virtual void advance(TimeNs t) { (void)t; }
  /// The points, in order of time, become known at `t`. Each counts from its own time + `delay` on, and not before `t`;
  /// a time outside those of its frame is taken as the nearer end.
  virtual void extend(std::span<const WorldPoint> points, TimeNs t) = 0;
  /// Forget what lies farther than `radius` [m] from `centre_W`; amortised: what lies farther may stay until
  /// the centre has moved by a tenth of the radius, and in the corners of the cube around it. So a metric
  /// may leave out points whose range is beyond nine tenths of the radius: they would be forgotten on the way.
  virtual void trim(const Vec3& centre_W, double radius) = 0;
  /// Whether a frame holds points of earlier calls, too, beside which fewer new ones would count for less.
  virtual bool frames_reach_back() const { return false; }
  /// Forgets everything, as if nothing had been extended.
  virtual void clear() = 0;
  virtual std::size_t memory_bytes() const = 0;
};

/// Integer voxel coordinates, floor(p / voxel) per axis.
struct Cell {
  std::int32_t x = 0, y = 0, z = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Per axis a cell is in [-kCellRange, kCellRange).
inline constexpr std::int32_t kCellRange = 1 << 20;

/// 3 x 21 bits; differences of keys are differences of cells, as long as no axis leaves its range.
/// Pre: -kCellRange <= c < kCellRange per axis.
constexpr std::uint64_t pack_cell(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::uint64_t>(x + kCellRange) << 42 | static_cast<std::uint64_t>(y + kCellRange) << 21 |
         static_cast<std::uint64_t>(z + kCellRange);
}

/// Distance between cells in voxel units that defines a layer.
enum class LayerMetric : std::uint8_t { chebyshev, manhattan, euclid_rounded };

/// Occupied cells of an overlap metric. All stores give identical layers. Cells outside kCellRange are refused by
/// the caller. layers(): smallest distance (metric units, 0..depth) from cells[i] to an occupied cell, or depth + 1 if
/// none is within depth. Not thread-safe for writing; layers() may be called concurrently unless stated otherwise.
class OccupancyStore : public Stage {
 public:
  static constexpr std::string_view family = "stores";
  virtual void insert(std::span<const Cell> cells) = 0;
  virtual void layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) = 0;
  /// Drops cells outside the axis-aligned cube [lo, hi].
  virtual void keep_inside(const Cell& lo, const Cell& hi) = 0;
  virtual std::size_t size() const = 0;
  virtual std::size_t memory_bytes() const = 0;
  virtual void clear() = 0;
};

}  // namespace aslio
