#pragma once

#include <cmath>

#include "aslio/simulator/motion.hpp"
#include "jet.hpp"

namespace aslio::simulator {

/// The state at a place with an attitude R = Rz(yaw) Ry(pitch) Rx(roll): its angular rate, in the body frame, follows
/// from the rates of the angles.
inline MotionState motion_state(const Jet& x, const Jet& y, const Jet& z, const Jet& yaw, const Jet& pitch,
                                const Jet& roll) {
  MotionState state;
  state.p << x.x, y.x, z.x;
  state.v << x.d, y.d, z.d;
  state.a << x.dd, y.dd, z.dd;
  const double cy = std::cos(yaw.x), sy = std::sin(yaw.x), cp = std::cos(pitch.x), sp = std::sin(pitch.x);
  const double cr = std::cos(roll.x), sr = std::sin(roll.x);
  state.R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,         //
      -sp, cp * sr, cp * cr;
  state.w << roll.d - yaw.d * sp, pitch.d * cr + yaw.d * cp * sr, yaw.d * cp * cr - pitch.d * sr;
  return state;
}

}  // namespace aslio::simulator
