#pragma once

#include <cstdint>
#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/core/types.hpp"
#include "aslio/simulator/motion.hpp"

namespace aslio::simulator {

/// A BMI088 as built into the Avia: white noise and bias walk by the densities of the sensor model, per-sample standard
/// deviation = density * sqrt(rate); initial biases uniform; clipped.
struct ImuModel {
  double rate = 200;                        ///< [Hz]
  double initial_gyro_bias = 8.727e-3;      ///< up to this, per axis [rad/s] (0.5 deg/s)
  double initial_acc_bias = 0.196133;       ///< up to this, per axis [m/s^2] (20 mg)
  double gyro_range = 34.9;                 ///< [rad/s]
  double acc_range = 3 * kStandardGravity;  ///< [m/s^2]
  double scale_error = 0;    ///< standard deviation of each axis' scale factor, gyro and accelerometer alike
  double cross_axis = 0;     ///< standard deviation of each off-diagonal term of the sensitivity matrix
  double g_sensitivity = 0;  ///< standard deviation of each term of the gyro's response to force [rad/s per m/s^2]
  double delay = 0;          ///< a sample tells of the motion this much earlier (low-pass filter) [s]
};

/// Samples and the true biases at their times.
struct ImuRecord {
  std::vector<ImuSample> samples;
  std::vector<Vec3> gyro_bias, acc_bias;
};

/// Samples from `begin` (motion time 0) over `duration` seconds, both ends included. Without noise: no bias either.
ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model,
                       const SensorModel& sensor, bool noise, std::uint64_t seed);

}  // namespace aslio::simulator
