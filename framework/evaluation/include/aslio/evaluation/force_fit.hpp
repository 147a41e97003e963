#pragma once
/// What an accelerometer says of poses that something else has measured: signs, gravity, and where that other is.

#include <span>
#include <string>

#include "aslio/evaluation/turns.hpp"

namespace aslio::evaluation {

struct ForceFitOptions {
  Mat3 R_I_A = Mat3::Identity();         ///< rotation of the body A of the poses in the IMU frame
  double delay = 0;                      ///< what A shows at its stamp t, the IMU shows at its stamp t + delay [s]
  Vec3 gyro_bias = Vec3::Zero();         ///< [rad/s]
  Mat3 gyro_sensitivity = Mat3::Zero();  ///< S of a gyro that measures (I + S) w and the bias
  Vec3 gyro_signs = Vec3::Ones();
  Vec3 expected = Vec3::Zero();  ///< [m] lever arm by the files: what the data leave open is as it says
  double piece = 1.5;            ///< [s] over which the specific force is integrated
};

struct ForceFit {
  std::string problem;  ///< why there is none; empty: there is one
  std::size_t pieces = 0;
  Vec3 scale = Vec3::Ones();  ///< of the axes of the accelerometer: about 1, or -1 where the sign is wrong
  Vec3 sigma_scale = Vec3::Zero();
  Vec3 signs = Vec3::Ones();              ///< -1 where the scale is negative beyond doubt
  Vec3 lever = Vec3::Zero();              ///< position of A in the IMU frame [m]
  Mat3 covariance = Mat3::Zero();         ///< of it [m^2]
  double gravity = 0, sigma_gravity = 0;  ///< length of what has to be added to the specific force [m/s^2]
  Vec3 up = Vec3::Zero();                 ///< mean direction against it, in the world of A
  double rms = 0;                         ///< [m]
};

/// Integrates the specific force twice over pieces and compares with the positions: start, velocity and gravity of each
/// piece are free, scales, bias and lever arm are common to all. eq. FRM-5
ForceFit fit_force(std::span<const MotionStretch> a, std::span<const ImuSample> imu, const ForceFitOptions& options);

}  // namespace aslio::evaluation
