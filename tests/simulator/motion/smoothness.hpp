#pragma once
/// Measures of a motion by finite differences.

#include <algorithm>
#include <cmath>

#include "aslio/simulator/motion.hpp"

namespace aslio::simulator::test {

/// Largest differences between what a motion says of its derivatives and central differences (fourth order) of its
/// pose and velocity, every `step` seconds from before its start until after its end.
struct DerivativeErrors {
  double velocity = 0, acceleration = 0, rate = 0, rotation = 0;
};
inline DerivativeErrors derivative_errors(const Motion& motion, double step) {
  constexpr double h = 2e-4;
  DerivativeErrors worst;
  for (double t = -0.5; t < motion.duration() + 0.5; t += step) {
    const MotionState m = motion.at(t), a = motion.at(t - 2 * h), b = motion.at(t - h), c = motion.at(t + h),
                      d = motion.at(t + 2 * h);
    const auto derivative = [](const Vec3& far_back, const Vec3& back, const Vec3& on, const Vec3& far_on) -> Vec3 {
      return (8 * (on - back) - (far_on - far_back)) / (12 * h);
    };
    const auto turned = [&](const MotionState& other) { return log_so3(m.R.transpose() * other.R); };
    worst.velocity = std::max(worst.velocity, (derivative(a.p, b.p, c.p, d.p) - m.v).norm());
    worst.acceleration = std::max(worst.acceleration, (derivative(a.v, b.v, c.v, d.v) - m.a).norm());
    worst.rate = std::max(worst.rate, (derivative(turned(a), turned(b), turned(c), turned(d)) - m.w).norm());
    worst.rotation = std::max(worst.rotation, (m.R.transpose() * m.R - Mat3::Identity()).norm());
  }
  return worst;
}

/// Largest change within one step of the third derivative of the position [m/s^3] and of the second derivative of the
/// angular rate [rad/s^3], at every step of the motion: in proportion to the step where they are continuous, no less
/// than about half of the jump where they are not.
struct LargestChanges {
  double jerk = 0, rate_curvature = 0;
};
inline LargestChanges largest_changes(const Motion& motion, double h) {
  LargestChanges worst;
  const auto count = static_cast<long>((motion.duration() + 0.2) / h);
  const auto at = [&](long k) { return motion.at(static_cast<double>(k) * h - 0.1); };
  MotionState a = at(0), b = at(1), c = at(2);
  for (long k = 3; k < count; ++k) {
    const MotionState d = at(k);
    worst.jerk = std::max(worst.jerk, (d.a - 2 * c.a + b.a).norm() / h);
    worst.rate_curvature = std::max(worst.rate_curvature, (d.w - 3 * c.w + 3 * b.w - a.w).norm() / (h * h));
    a = b;
    b = c;
    c = d;
  }
  return worst;
}

}  // namespace aslio::simulator::test
