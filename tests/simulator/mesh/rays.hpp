#pragma once

#include <cmath>
#include <numbers>

#include "aslio/core/lie.hpp"
#include "aslio/simulator/random.hpp"

namespace aslio::test {

inline Vec3 in_cube(simulator::RandomStream& random, double bound) {
  const double x = random.uniform(-bound, bound), y = random.uniform(-bound, bound);
  return {x, y, random.uniform(-bound, bound)};
}

/// Uniform on the unit sphere.
inline Vec3 any_direction(simulator::RandomStream& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace aslio::test
