#pragma once
/// A real IMU as scene files describe it.

#include <cstdint>
#include <optional>

#include "aslio/simulator/imu_model.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

enum class ImuPreset : std::uint8_t {
  perfect,    ///< exact derivatives, nothing else
  ideal,      ///< white noise, biases and their walk; perfectly calibrated
  datasheet,  ///< `ideal` with the imperfections of a BMI088: scale, cross-axis, g-sensitivity, filter delay
};

/// `imu:` of a scene file. Absent values are those of the preset.
struct ImuParams {
  ImuPreset preset = ImuPreset::datasheet;
  double rate = 200;                                    ///< [Hz]
  std::optional<double> gyro_noise, acc_noise;          ///< densities [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]
  std::optional<double> gyro_bias, acc_bias;            ///< initial, uniform up to this per axis [deg/s], [mg]
  std::optional<double> gyro_bias_walk, acc_bias_walk;  ///< [rad/s^2/sqrt(Hz)], [m/s^3/sqrt(Hz)]
  std::optional<double> scale_error;                    ///< standard deviation per axis, both sensors [%]
  std::optional<double> cross_axis;                     ///< standard deviation of each off-diagonal term [%]
  std::optional<double> g_sensitivity;                  ///< standard deviation of each term [deg/s per g]
  std::optional<double> delay;  ///< of the low-pass filter: a sample tells of this much earlier [ms]
  double gyro_range = 2000;     ///< [deg/s]
  double acc_range = 3;         ///< [g]
  static void describe(config::Binder& b, ImuParams& params);
};

/// The model with the preset's and the given values.
ImuModel imu_model(const ImuParams& params);

}  // namespace aslio::simulator
