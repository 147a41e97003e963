#include "aslio/simulator/imu_params.hpp"

#include <limits>

#include "aslio/config/binder.hpp"
#include "aslio/core/angles.hpp"

namespace aslio::simulator {
namespace {

constexpr double kMilliG = 1e-3 * kStandardGravity;
constexpr double kPercent = 0.01;
constexpr double kDegreePerSecondPerG = kRadPerDeg / kStandardGravity;
constexpr double kMillisecond = 1e-3;
constexpr std::string_view kPresets = "= the preset's";

ImuModel preset_model(ImuPreset preset) {
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  ImuModel model;
  if (preset == ImuPreset::perfect) {
    // Without noise a sensor that stands still repeats its reading to the last bit, and is taken for a dead one.
    model.gyro_noise = 1e-9;
    model.acc_noise = 1e-8;
    model.gyro_bias_walk = model.acc_bias_walk = 0;
    model.initial_gyro_bias = model.initial_acc_bias = 0;
    model.gyro_range = model.acc_range = kUnlimited;
    return model;
  }
  model.initial_gyro_bias = 0.5 * kRadPerDeg;
  model.initial_acc_bias = 20 * kMilliG;
  model.gyro_range = 2000 * kRadPerDeg;
  model.acc_range = 3 * kStandardGravity;
  if (preset == ImuPreset::datasheet) {
    model.scale_error = 1 * kPercent;
    model.cross_axis = 0.5 * kPercent;
    model.g_sensitivity = 0.1 * kDegreePerSecondPerG;
    model.delay = 2 * kMillisecond;
  }
  return model;
}

void override_with(const std::optional<double>& value, double unit, double& out) {
  if (value) out = *value * unit;
}

void describe_noise(config::Binder& b, ImuParams& p) {
  const config::Range density{.min = 0.0, .max = 1.0};
  b.optional_real("gyro_noise", p.gyro_noise, "rad/s/sqrt(Hz)", density, kPresets, "density of the gyro's white noise");
  b.optional_real("acc_noise", p.acc_noise, "m/s^2/sqrt(Hz)", density, kPresets,
                  "density of the accelerometer's white noise");
  b.optional_real("gyro_bias", p.gyro_bias, "deg/s", {.min = 0.0, .max = 20.0}, kPresets,
                  "initial bias of the gyro, uniform up to this per axis");
  b.optional_real("acc_bias", p.acc_bias, "mg", {.min = 0.0, .max = 500.0}, kPresets,
                  "initial bias of the accelerometer, uniform up to this per axis");
  b.optional_real("gyro_bias_walk", p.gyro_bias_walk, "rad/s^2/sqrt(Hz)", density, kPresets,
                  "density of the random walk of the gyro's bias");
  b.optional_real("acc_bias_walk", p.acc_bias_walk, "m/s^3/sqrt(Hz)", density, kPresets,
                  "density of the random walk of the accelerometer's bias");
}

void describe_calibration(config::Binder& b, ImuParams& p) {
  b.optional_real("scale_error", p.scale_error, "%", {.min = 0.0, .max = 20.0}, kPresets,
                  "scale factor of each axis of both sensors, uniform up to this");
  b.optional_real("cross_axis", p.cross_axis, "%", {.min = 0.0, .max = 20.0}, kPresets,
                  "part of one axis that another one measures, uniform up to this, both sensors");
  b.optional_real("g_sensitivity", p.g_sensitivity, "deg/s per g", {.min = 0.0, .max = 10.0}, kPresets,
                  "response of each gyro axis to force along each axis, uniform up to this");
  b.optional_real("delay", p.delay, "ms", {.min = 0.0, .max = 100.0}, kPresets,
                  "of the low-pass filter: a sample shows the motion this much earlier");
  b.optional_real("gyro_range", p.gyro_range, "deg/s", {.above = 0.0, .max = 10000.0}, kPresets,
                  "where the gyro is clipped");
  b.optional_real("acc_range", p.acc_range, "g", {.above = 1.0, .max = 1000.0}, kPresets,
                  "where the accelerometer is clipped");
}

}  // namespace

void ImuParams::describe(config::Binder& b, ImuParams& params) {
  b.choice("preset", params.preset,
           {{"perfect", ImuPreset::perfect}, {"ideal", ImuPreset::ideal}, {"datasheet", ImuPreset::datasheet}},
           "perfect: exact but for the last digits, and unlimited. ideal: noise and biases of a BMI088, 2000 deg/s, 3 "
           "g. datasheet: ideal with "
           "scale error 1 %, cross-axis 0.5 %, g-sensitivity 0.1 deg/s per g, delay 2 ms");
  b.real("rate", params.rate, "Hz", {.min = 5.0, .max = 10000.0}, "samples per second");
  describe_noise(b, params);
  describe_calibration(b, params);
}

ImuModel imu_model(const ImuParams& params) {
  ImuModel model = preset_model(params.preset);
  model.rate = params.rate;
  override_with(params.gyro_noise, 1, model.gyro_noise);
  override_with(params.acc_noise, 1, model.acc_noise);
  override_with(params.gyro_bias, kRadPerDeg, model.initial_gyro_bias);
  override_with(params.acc_bias, kMilliG, model.initial_acc_bias);
  override_with(params.gyro_bias_walk, 1, model.gyro_bias_walk);
  override_with(params.acc_bias_walk, 1, model.acc_bias_walk);
  override_with(params.scale_error, kPercent, model.scale_error);
  override_with(params.cross_axis, kPercent, model.cross_axis);
  override_with(params.g_sensitivity, kDegreePerSecondPerG, model.g_sensitivity);
  override_with(params.delay, kMillisecond, model.delay);
  override_with(params.gyro_range, kRadPerDeg, model.gyro_range);
  override_with(params.acc_range, kStandardGravity, model.acc_range);
  return model;
}

}  // namespace aslio::simulator
