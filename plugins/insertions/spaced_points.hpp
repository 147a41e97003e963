#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/points.hpp"

namespace aslio::plugins {

/// Points of one batch none of which is nearer than `spacing` to one taken before it.
class SpacedPoints {
 public:
  explicit SpacedPoints(double spacing) : spacing_(spacing) {}

  /// Forgets the last batch and prepares for up to `most` points.
  void begin(std::size_t most);
  /// Takes the point unless it is too near to another, not finite, or beyond all cells.
  void offer(const WorldPoint& point);
  std::span<const WorldPoint> taken() const { return taken_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  std::size_t bucket(std::int64_t x, std::int64_t y, std::int64_t z) const;
  bool near_one_of(std::size_t bucket, const Vec3& p) const;

  double spacing_;
  std::vector<WorldPoint> taken_;
  std::vector<std::uint32_t> first_;  ///< by bucket, a power of two of them
  std::vector<std::uint32_t> next_;   ///< by point: another one of its bucket
};

}  // namespace aslio::plugins
