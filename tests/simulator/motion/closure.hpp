#pragma once
/// Checks of the ends of a walk.

#include <catch2/catch.hpp>

#include "aslio/simulator/motion.hpp"

namespace aslio::simulator::test {

inline void check_closed(const Motion& motion, double standstill) {
  const MotionState begin = motion.at(0), end = motion.at(motion.duration());
  CHECK((begin.p - end.p).norm() < 1e-9);
  CHECK(log_so3(begin.R.transpose() * end.R).norm() < 1e-9);
  for (double rest = 0; rest <= standstill + 0.3; rest += 0.01) {
    const MotionState m = motion.at(motion.duration() + 0.3 - rest);
    REQUIRE((m.p - end.p).norm() < 1e-9);
    REQUIRE(m.v.norm() + m.a.norm() + m.w.norm() < 1e-9);
  }
}

inline void check_still_before(const Motion& motion, double until) {
  for (double t = -0.3; t <= until; t += 0.01) {
    const MotionState m = motion.at(t);
    REQUIRE((m.p - motion.at(0).p).norm() < 1e-12);
    REQUIRE(m.v.norm() + m.a.norm() + m.w.norm() < 1e-9);
  }
}

}  // namespace aslio::simulator::test
