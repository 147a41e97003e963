#pragma once
/// What two IMU samples say of the motion between them.

#include "aslio/core/types.hpp"

namespace aslio {

/// Mean input of one interval (docs/equations.md MOT-6): what the samples say, and what the state makes of it.
struct ImuMean {
  ImuMean(const NavState& state, const ImuSample& from, const ImuSample& to)
      : dt(to_seconds(to.t - from.t)),
        w_measured(0.5 * (from.gyro + to.gyro)),
        w_change(dt > 0 ? Vec3((to.gyro - from.gyro) / dt) : Vec3::Zero()),
        a_change(dt > 0 ? Vec3((to.acc - from.acc) / dt) : Vec3::Zero()),
        w(w_measured - state.b_w - state.S_w * w_measured + state.imu_delay * w_change),
        a(0.5 * (from.acc + to.acc) - state.b_a + state.imu_delay * a_change) {}

  double dt;        ///< [s]
  Vec3 w_measured;  ///< mean of the two samples [rad/s]
  Vec3 w_change;    ///< rate of change of the measured rate [rad/s^2]
  Vec3 a_change;    ///< rate of change of the measured specific force [m/s^3]
  Vec3 w, a;        ///< rate and specific force without bias, sensitivity error and delay
};

}  // namespace aslio
