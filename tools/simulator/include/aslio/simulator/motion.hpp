#pragma once
/// Motion of the IMU through the world, in closed form: what is simulated is exact at any time.

#include "aslio/core/lie.hpp"

namespace aslio::simulator {

/// Pose of the IMU in the world and its derivatives.
struct MotionState {
  Mat3 R = Mat3::Identity();  ///< R_W_I
  Vec3 p = Vec3::Zero();      ///< [m]
  Vec3 v = Vec3::Zero();      ///< [m/s], in W
  Vec3 a = Vec3::Zero();      ///< [m/s^2], in W
  Vec3 w = Vec3::Zero();      ///< angular rate in I [rad/s]
};

/// Three times continuously differentiable. Thread-compatible: const.
class Motion {
 public:
  virtual ~Motion() = default;
  /// State `t` seconds after the start; before the start and after the end as continued there.
  virtual MotionState at(double t) const = 0;
  /// [s]
  virtual double duration() const = 0;
};

}  // namespace aslio::simulator
