#pragma once

#include <vector>

#include "aslio/core/lie.hpp"

namespace test {

/// Axes, diagonals and oblique unit vectors: each of the four branches of the quaternion of a matrix is met near pi.
inline std::vector<aslio::Vec3> directions() {
  std::vector<aslio::Vec3> all;
  for (const double sign : {1.0, -1.0}) {
    for (int i = 0; i < 3; ++i) all.push_back(sign * aslio::Vec3::Unit(i));
    all.push_back(sign * aslio::Vec3(1, 1, 1).normalized());
    all.push_back(sign * aslio::Vec3(1, -2, 0.5).normalized());
    all.push_back(sign * aslio::Vec3(-0.1, 0.2, 3).normalized());
    all.push_back(sign * aslio::Vec3(1e-5, 1, -1e-5).normalized());
  }
  return all;
}

}  // namespace test
