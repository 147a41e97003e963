#pragma once
/// A road and a ground that the tests of drives use.

#include "aslio/simulator/drive.hpp"

namespace aslio::simulator::test {

/// 400 m with a bend of 90 deg to the left, one of 45 deg to the right and one of 90 deg to the right.
inline RoadLine bent_road() { return RoadLine({{0, 0}, {120, 0}, {120, 80}, {180, 140}, {280, 40}}, 12); }

inline Ground hills() {
  Ground ground;
  ground.waves = {{0.5, 0.03, 0.02, 0.5}, {0.1, -0.06, 0.08, 1.0}};
  return ground;
}

/// 8 m/s at time 0, one stop, one limit, to a stop.
inline DriveParams stop_and_go() {
  DriveParams params;
  params.start_speed = 8;
  params.stops = {{0.12, 2}};
  params.limits = {{0.85, 0.95, 6}};
  return params;
}

}  // namespace aslio::simulator::test
