#pragma once
/// Motions that IMU tests measure.

#include "aslio/simulator/walk.hpp"

namespace aslio::simulator::test {

/// One hour of standing still (as continued: for ever).
inline Walk standing() { return {{{0, 0, 0, 0, 0}, {3600, 0, 0, 0, 0}}, {}, {.height = 0, .roll = 0, .pitch = 0}, 1}; }

/// 60 s to and fro with turns and a strong gait: every axis of both sensors is moved.
inline Walk rich() {
  std::vector<Waypoint> waypoints{{0, 0, 0, 0, 0}};
  std::vector<Turn> turns;
  for (int k = 1; k < 20; ++k) {
    const double side = k % 2 == 0 ? 1 : -1;
    waypoints.push_back({3.0 * k, 2.0 * side, 1.5 * (k % 3), 0.5 * side, -0.8 * side});
    turns.push_back({3.0 * k, 0.8, 1.5 * side});
  }
  waypoints.push_back({60, 0, 0, 0, 0});
  return {waypoints, turns, {.frequency = 1.8, .height = 0.05, .roll = 0.3, .pitch = 0.2, .fade = 1}, 1};
}

}  // namespace aslio::simulator::test
