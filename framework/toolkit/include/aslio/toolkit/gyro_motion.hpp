#pragma once
/// The simplest prediction with an IMU: the gyro turns, the velocity stays.

#include "aslio/stages/motion.hpp"

namespace aslio {

/// Advances `state` from one sample to the next: turned by the mean rate less the bias, moved on with its velocity.
/// Returns the segment.
inline MotionSegment turn_and_coast(NavState& state, const ImuSample& from, const ImuSample& to) {
  MotionSegment segment{.t = from.t, .dt = to_seconds(to.t - from.t), .R = state.R, .p = state.p, .v = state.v};
  segment.w = 0.5 * (from.gyro + to.gyro) - state.b_w;
  state.R = orthonormalised(state.R * exp_so3(segment.dt * segment.w));
  state.p += segment.dt * state.v;
  state.t = to.t;
  return segment;
}

}  // namespace aslio
