#pragma once
/// Turns of the head found in a walk.

#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/simulator/motion.hpp"

namespace aslio::simulator::test {

/// A change of heading without rest in between.
struct Swing {
  double begin = 0, duration = 0;  ///< [s]
  double angle = 0, peak = 0;      ///< [deg], [deg/s]
};

/// Of a walk whose gait does not turn.
inline std::vector<Swing> swings(const Motion& walk) {
  constexpr double kDeg = std::numbers::pi / 180, step = 1e-3, still = 1e-9;
  std::vector<Swing> all;
  bool turning = false;
  for (double t = 0; t < walk.duration(); t += step) {
    const double rate = walk.at(t).w.z() / kDeg;
    const bool now = std::abs(rate) > still;
    if (now && (!turning || all.back().angle * rate < 0)) all.push_back({t, 0, 0, 0});
    turning = now;
    if (!now) continue;
    all.back().duration += step;
    all.back().angle += step * rate;
    all.back().peak = std::max(all.back().peak, std::abs(rate));
  }
  return all;
}

}  // namespace aslio::simulator::test
