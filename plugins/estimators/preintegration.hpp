#pragma once
/// What the IMU says of the motion between two states, whatever the first one is (Forster et al., TRO 2017).

#include <span>

#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// Densities of the IMU, and of the integration itself.
struct InertialNoise {
  double gyro = 1.56e-3;      ///< [rad/s/sqrt(Hz)]
  double acc = 3.99e-3;       ///< [m/s^2/sqrt(Hz)]
  double gyro_bias = 3.6e-5;  ///< [rad/s^2/sqrt(Hz)]
  double acc_bias = 6.4e-5;   ///< [m/s^3/sqrt(Hz)]
  double integration = 1e-4;  ///< of the position [m/sqrt(s)]

  /// Over a window that reaches into a gap of the IMU [ns] (Window::imu_gap; 0: none). eq. MOT-9.
  InertialNoise over(TimeNs imu_gap) const;
};

/// R_j = R_i dR, v_j = v_i + g t + R_i dv, p_j = p_i + v_i t + g t^2 / 2 + R_i dp, by the midpoint rule of MOT-1.
/// eqs. PRE-1 to PRE-3
struct Preintegration {
  using Mat9 = Eigen::Matrix<double, 9, 9>;

  /// Reads the IMU with the biases and the calibration of `known`.
  Preintegration(std::span<const ImuSample> samples, const NavState& known, const InertialNoise& noise);

  double seconds = 0;
  Vec3 b_w, b_a;  ///< biases it was made with
  Mat3 dR = Mat3::Identity();
  Vec3 dv = Vec3::Zero(), dp = Vec3::Zero();
  /// Exp(dR_bw d) to the right of dR, and the others added, for biases that are larger by d. First order.
  Mat3 dR_bw = Mat3::Zero(), dv_bw = Mat3::Zero(), dv_ba = Mat3::Zero(), dp_bw = Mat3::Zero(), dp_ba = Mat3::Zero();
  Mat9 covariance = Mat9::Zero();  ///< of (theta, p, v), theta to the right of dR

 private:
  void step(const ImuSample& from, const ImuSample& to, const NavState& known, const InertialNoise& noise);
};

}  // namespace aslio::plugins
