#pragma once

#include <cmath>

#include "aslio/core/trajectory.hpp"

namespace test {

/// A pose of a smooth three-dimensional path: an ellipse of 4 m by 3 m with ups and downs, `t` in seconds. It turns at
/// up to 2 rad/s for a second around t = 6 s and at less than 0.1 rad/s elsewhere.
inline aslio::Pose path(double t) {
  const double yaw = 0.08 * t + 2.0 / (1.0 + std::exp(-8.0 * (t - 6.0)));
  return {aslio::exp_so3(aslio::Vec3(0, 0, yaw)) * aslio::exp_so3(aslio::Vec3(0.1, 0.05, 0)),
          aslio::Vec3(4.0 * std::cos(0.5 * t), 3.0 * std::sin(0.5 * t), 0.4 * std::sin(1.3 * t))};
}

/// Samples of path() every `period` ns over [begin, end] ns.
inline aslio::Trajectory sampled(aslio::TimeNs begin, aslio::TimeNs end, aslio::TimeNs period) {
  aslio::Trajectory trajectory;
  for (aslio::TimeNs t = begin; t <= end; t += period) trajectory.append({t, path(aslio::to_seconds(t))});
  return trajectory;
}

/// The same motion as seen from another world: every pose becomes T * pose * body.
inline aslio::Trajectory moved(const aslio::Trajectory& trajectory, const aslio::Pose& T,
                               const aslio::Pose& body = {}) {
  aslio::Trajectory result;
  for (const aslio::StampedPose& sample : trajectory.samples()) result.append({sample.t, T * sample.T * body});
  return result;
}

inline constexpr aslio::TimeNs kMs = 1'000'000;

}  // namespace test
