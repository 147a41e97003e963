#pragma once
/// Routes and grounds that motion tests walk.

#include "aslio/simulator/route_walk.hpp"

namespace aslio::simulator::test {

/// Left and right turns, an obtuse and an acute corner, a point on a straight edge.
inline Route crooked() { return Route({{0, 0}, {7, 0}, {14, 0}, {14, 9}, {20, 14}, {11, 20}, {11, 10}, {0, 10}}); }
/// To a point and back.
inline Route out_and_back() { return Route({{1, 2}, {9, -3}}); }

/// Two waves and a ramp.
inline Ground hilly() {
  Ground ground;
  ground.waves = {{0.3, 0.2, 0.1, 0.5}, {0.1, -0.3, 0.4, 1.0}};
  ground.ramps = {{0.4, 3, 8, 1.2}};
  return ground;
}

inline constexpr GaitKind kGaits[] = {GaitKind::smooth, GaitKind::walking, GaitKind::oscillating, GaitKind::running};

}  // namespace aslio::simulator::test
