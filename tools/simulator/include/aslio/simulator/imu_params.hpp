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
  perfect,    ///< exact derivatives; white noise of 1e-9 rad/s, 1e-8 m/s^2 per root Hz, lest it seem stuck
  ideal,      ///< white noise, biases and their walk, clipped; perfectly calibrated
  datasheet,  ///< `ideal` with the imperfections of a BMI088: scale, cross-axis, g-sensitivity, filter delay
};

/// `imu:` of a scene file. Absent values are those of the preset. What a sensor has from birth (biases, scale factors,
/// cross-axis terms, g-sensitivity) is drawn from the seed, uniformly up to the given value: the data sheet's typical
/// limits are taken as bounds.
struct ImuParams {
  ImuPreset preset = ImuPreset::datasheet;
  double rate = 200;                                    ///< [Hz]
  std::optional<double> gyro_noise, acc_noise;          ///< densities [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]
  std::optional<double> gyro_bias, acc_bias;            ///< initial, up to this per axis [deg/s], [mg]
  std::optional<double> gyro_bias_walk, acc_bias_walk;  ///< [rad/s^2/sqrt(Hz)], [m/s^3/sqrt(Hz)]
  std::optional<double> scale_error;                    ///< up to this per axis, both sensors [%]
  std::optional<double> cross_axis;                     ///< up to this for each off-diagonal term, both sensors [%]
  std::optional<double> g_sensitivity;                  ///< up to this for each term [deg/s per g]
  std::optional<double> delay;  ///< of the low-pass filter: a sample shows the motion this much earlier [ms]
  std::optional<double> gyro_range, acc_range;  ///< where samples are clipped [deg/s], [g]
  static void describe(config::Binder& b, ImuParams& params);
};

/// The model with the preset's and the given values.
ImuModel imu_model(const ImuParams& params);

}  // namespace aslio::simulator
