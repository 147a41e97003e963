#pragma once

#include <span>
#include <vector>

#include "aslio/core/cell_index.hpp"
#include "aslio/stages/points.hpp"

namespace aslio::plugins {

/// Thins the points of a batch to the mean of each cube of a grid, as measured and at their mean time: what Point-LIO
/// feeds its filter with (docs/equations.md PTW-7). All storage is reused.
class CubeMeans {
 public:
  /// `leaf`: edge of a cube [m], > 0.
  explicit CubeMeans(double leaf) : inverse_edge_(1.0 / leaf) {}

  /// Means in LiDAR axes, in the order of time, of the points with a use. Each has the other properties of the first
  /// point of its cube. Points that are nowhere (not finite, or farther than the grid reaches) are left out. Valid
  /// until the next call.
  std::span<const TimedPoint> of(std::span<const TimedPoint> points, std::span<const PointUses> uses);

 private:
  struct Member {
    std::uint64_t cube = 0;
    std::uint32_t point = 0;
  };
  TimedPoint mean(std::span<const TimedPoint> points, std::span<const Member> cube) const;

  double inverse_edge_;
  std::vector<Member> members_;
  std::vector<TimedPoint> means_;
};

}  // namespace aslio::plugins
