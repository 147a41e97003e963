#pragma once

#include "aslio/core/lie.hpp"

namespace aslio {

/// What stages may know of the sensors. Extrinsics are known and fixed.
struct SensorModel {
  Pose T_imu_lidar;  ///< p_I = T_imu_lidar p_L
  int scan_lines = 6;
  double min_range = 0.5;           ///< [m], returns nearer are the carrier or noise
  double max_range = 100.0;         ///< [m]
  double sweep_period = 0.1;        ///< [s]
  double range_sigma = 0.02;        ///< one standard deviation of a measured range [m]
  double range_sigma_growth = 0.0;  ///< what a metre of range adds to it [m/m]
  double gyro_noise = 2.4435e-4;    ///< continuous density [rad/s/sqrt(Hz)] (BMI088 data sheet)
  double acc_noise = 1.716e-3;      ///< continuous density [m/s^2/sqrt(Hz)]
  double gyro_bias_walk = 2e-5;     ///< [rad/s^2/sqrt(Hz)]
  double acc_bias_walk = 1e-4;      ///< [m/s^3/sqrt(Hz)]
  double gyro_range = 0;            ///< largest rate that the gyro reports, each axis [rad/s]; 0: unknown
  double acc_range = 0;             ///< largest specific force, each axis [m/s^2]; 0: unknown
};

}  // namespace aslio
