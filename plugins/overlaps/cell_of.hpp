#pragma once
/// The voxel of a point.

#include <cmath>

#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// floor(p / voxel); false for a point that is not finite or whose cell is not within kCellRange.
inline bool cell_of(const Vec3& p, double inverse_voxel, Cell& out) {
  constexpr double limit = kCellRange;
  const double x = std::floor(p.x() * inverse_voxel), y = std::floor(p.y() * inverse_voxel),
               z = std::floor(p.z() * inverse_voxel);
  const auto fits = [](double c) { return c >= -limit && c < limit; };  // false for NaN
  if (!fits(x) || !fits(y) || !fits(z)) return false;
  out = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)};
  return true;
}

}  // namespace aslio::plugins
