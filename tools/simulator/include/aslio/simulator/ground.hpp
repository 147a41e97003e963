#pragma once
/// The ground people walk on, in closed form, so that a walk over it has exact derivatives.

#include <vector>

#include "aslio/core/lie.hpp"

namespace aslio::simulator {

/// Height [m] with its first and second derivatives by x and y.
struct GroundHeight {
  double z = 0, zx = 0, zy = 0, zxx = 0, zxy = 0, zyy = 0;
};

/// Level ground at height 0 plus waves and ramps; three times continuously differentiable.
struct Ground {
  /// amplitude * sin(kx x + ky y + phase)
  struct Wave {
    double amplitude = 0;   ///< [m]
    double kx = 0, ky = 0;  ///< [rad/m]
    double phase = 0;       ///< [rad]
  };
  /// Rises by `rise` between `begin` and `begin + length` along (cos heading, sin heading); level before and after.
  struct Ramp {
    double heading = 0;            ///< [rad]
    double begin = 0, length = 1;  ///< [m]
    double rise = 0;               ///< [m]
  };
  std::vector<Wave> waves;
  std::vector<Ramp> ramps;

  GroundHeight at(double x, double y) const;
  double height(double x, double y) const { return at(x, y).z; }
};

}  // namespace aslio::simulator
