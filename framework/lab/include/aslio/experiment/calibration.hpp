#pragma once
/// What a run has learnt of its IMU.

#include <optional>
#include <string>

#include "aslio/stages/estimator.hpp"

namespace aslio::experiment {

/// A value, and what the estimator claims to know it to (one standard deviation; 0: it is held fixed). The claim takes
/// the map for exact and the IMU for one without other errors, so it is a lower bound.
template <class T>
struct Estimate {
  T value, sigma;
};

/// Of the last update that calibration_of() takes and that did not lose the run. A part that the estimator holds fixed,
/// or has no covariance for, is left out.
struct Calibration {
  TimeNs t = 0;
  std::optional<Estimate<Vec3>> gyro_bias;         ///< [rad/s]
  std::optional<Estimate<Vec3>> acc_bias;          ///< [m/s^2]
  std::optional<Estimate<Mat3>> gyro_sensitivity;  ///< NavState::S_w
  std::optional<Estimate<double>> imu_delay;       ///< NavState::imu_delay [s]
  std::optional<Estimate<Vec3>> extrinsic_turn;    ///< of T_imu_lidar against the sensor file's, in L [rad]
  std::optional<Estimate<Vec3>> extrinsic_shift;   ///< the same, in I [m]
  std::optional<Estimate<Vec3>> acc_scale;         ///< SensorEstimate::acc_scale
  Pose T_imu_lidar;                                ///< as estimated, where extrinsic_turn is
};

/// Of an update that is accepted and finite and has not let go what it knew to begin anew; nothing where no part is
/// estimated.
std::optional<Calibration> calibration_of(const Update& update);

/// "gyro scale +0.62 +- 0.19, -0.31 +- 0.06, +0.88 +- 0.01 %, cross-axis up to 0.41 +- 0.07 %, IMU delay 2.03 +- 0.02
/// ms": what is not the biases'. Empty when none of it is estimated.
std::string to_text(const Calibration& calibration);

}  // namespace aslio::experiment
