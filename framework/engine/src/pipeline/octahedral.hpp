#pragma once
/// Directions as cells of a square.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace aslio::pipeline {

/// Cell of the octahedral map (as PackedDirection) that holds a direction, of `side` cells per axis. `sum`: of the
/// absolute coordinates of `d`, finite and above 0.
inline std::size_t octahedral_cell(const Eigen::Vector3f& d, float sum, int side) {
  float a = d.x() / sum, b = d.y() / sum;
  if (d.z() < 0) {
    const float x = a;
    a = std::copysign(1.0F - std::abs(b), a);
    b = std::copysign(1.0F - std::abs(x), b);
  }
  const auto at = [side](float v) {
    return std::clamp(static_cast<int>(0.5F * (v + 1.0F) * static_cast<float>(side)), 0, side - 1);
  };
  return static_cast<std::size_t>(at(a) * side + at(b));
}

}  // namespace aslio::pipeline
