#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace aslio::plugins {

/// Which of eight halves `p` lies in, about the corner `low` with the half edge `half`; moves `low` to its corner.
inline std::uint32_t descend(const Eigen::Vector3f& p, float half, Eigen::Vector3f& low) {
  std::uint32_t octant = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (p[axis] < low[axis] + half) continue;
    octant |= 1U << axis;
    low[axis] += half;
  }
  return octant;
}

}  // namespace aslio::plugins
