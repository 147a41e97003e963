#include "aslio/simulator/imu_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

/// Temperature coefficients of the offsets of a BMI088 (data sheet: 0.015 deg/s/K, 0.2 mg/K), as bounds.
constexpr double kGyroPerKelvin = 0.015 * kRadPerDeg, kAccPerKelvin = 0.2e-3 * kStandardGravity;
constexpr int kFilterSteps = 16;

Vec3 normal3(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Vec3 uniform3(RandomStream& random, double bound) {
  const double x = random.uniform(-bound, bound), y = random.uniform(-bound, bound), z = random.uniform(-bound, bound);
  return {x, y, z};
}

Vec3 clipped(const Vec3& v, double range) { return v.cwiseMax(-range).cwiseMin(range); }

/// Terms on and off the diagonal, uniform up to their bounds.
Mat3 uniform_matrix(RandomStream& random, double diagonal, double off_diagonal) {
  Mat3 m;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      m(row, column) = (row == column ? diagonal : off_diagonal) * random.uniform(-1, 1);
  }
  return m;
}

ImuCalibration calibration_of(const ImuModel& model, std::uint64_t seed) {
  RandomStream random(seed, purpose::kImuCalibration);
  ImuCalibration c;
  c.gyro_sensitivity += uniform_matrix(random, model.scale_error, model.cross_axis);
  c.acc_sensitivity += uniform_matrix(random, model.scale_error, model.cross_axis);
  c.g_sensitivity = uniform_matrix(random, model.g_sensitivity, model.g_sensitivity);
  return c;
}

}  // namespace

ImuSimulator::ImuSimulator(const Motion& motion, TimeNs begin, const ImuModel& model, std::uint64_t seed)
    : motion_(motion),
      begin_(begin),
      model_(model),
      calibration_(calibration_of(model, seed)),
      walk_(seed, purpose::kBiasWalk),
      gyro_noise_(seed, purpose::kGyroNoise),
      acc_noise_(seed, purpose::kAccNoise) {
  RandomStream initial(seed, purpose::kInitialBias);
  gyro_bias_ = uniform3(initial, model.initial_gyro_bias);
  acc_bias_ = uniform3(initial, model.initial_acc_bias);
  RandomStream temperature(seed, purpose::kTemperature), vibration(seed, purpose::kVibration);
  gyro_per_kelvin_ = uniform3(temperature, kGyroPerKelvin);
  acc_per_kelvin_ = uniform3(temperature, kAccPerKelvin);
  vibration_phase_ = uniform3(vibration, std::numbers::pi);
}

ImuSimulator::Seen ImuSimulator::acting(double t) const {
  const Vec3 gravity(0, 0, -kStandardGravity);
  const MotionState m = motion_.at(t);
  Seen seen{m.w, m.R.transpose() * (m.a - gravity)};
  const double w = 2 * std::numbers::pi * model_.motor;
  if (model_.vibration > 0 && w > 0)
    for (int axis = 0; axis < 3; ++axis)
      seen.force[axis] += model_.vibration * std::sin(w * t + vibration_phase_[axis]);
  return seen;
}

ImuSimulator::Seen ImuSimulator::filtered(double t) const {
  if (model_.filter <= 0) return acting(t);
  Seen mean;
  for (int k = 0; k < kFilterSteps; ++k) {
    const Seen seen = acting(t + model_.filter * ((k + 0.5) / kFilterSteps - 0.5));
    mean.rate += seen.rate / kFilterSteps;
    mean.force += seen.force / kFilterSteps;
  }
  return mean;
}

ImuSimulator::Output ImuSimulator::next() {
  const double root_rate = std::sqrt(model_.rate);
  const TimeNs since = to_ns(static_cast<double>(count_++) / model_.rate);
  const auto [rate, force] = filtered(to_seconds(since) - model_.delay);

  Output out{{begin_ + since, Vec3::Zero(), Vec3::Zero()}, gyro_bias_, acc_bias_};
  if (model_.warming > 0) {
    const double kelvin = -model_.warming * std::expm1(-to_seconds(since) / kWarmUpTime);
    out.gyro_bias += kelvin * gyro_per_kelvin_;
    out.acc_bias += kelvin * acc_per_kelvin_;
  }
  ImuSample& sample = out.sample;
  sample.gyro = calibration_.gyro_sensitivity * rate + calibration_.g_sensitivity * force + out.gyro_bias;
  sample.acc = calibration_.acc_sensitivity * force + out.acc_bias;
  // Drawn with densities of zero, too: both walks share a stream.
  sample.gyro += model_.gyro_noise * root_rate * normal3(gyro_noise_);
  sample.acc += model_.acc_noise * root_rate * normal3(acc_noise_);
  sample.gyro = clipped(sample.gyro, model_.gyro_range);
  sample.acc = clipped(sample.acc, model_.acc_range);

  gyro_bias_ += model_.gyro_bias_walk / root_rate * normal3(walk_);
  acc_bias_ += model_.acc_bias_walk / root_rate * normal3(walk_);
  return out;
}

ImuModel with_realism(ImuModel model, const ImuRealism& realism, double motor) {
  model.filter = realism.filter / model.rate;
  model.delay = std::max(model.delay, 0.5 * model.filter);
  model.motor = motor;
  model.warming = realism.temperature;
  model.vibration = realism.vibration;
  return model;
}

ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model, std::uint64_t seed) {
  const auto count = static_cast<std::size_t>(std::floor(duration * model.rate + 1e-6)) + 1;
  ImuSimulator imu(motion, begin, model, seed);
  ImuRecord record;
  record.samples.reserve(count);
  record.gyro_bias.reserve(count);
  record.acc_bias.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const ImuSimulator::Output out = imu.next();
    record.samples.push_back(out.sample);
    record.gyro_bias.push_back(out.gyro_bias);
    record.acc_bias.push_back(out.acc_bias);
  }
  return record;
}

ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model,
                       const SensorModel& sensor, bool noise, std::uint64_t seed) {
  ImuModel full = model;
  full.gyro_noise = noise ? sensor.gyro_noise : 0;
  full.acc_noise = noise ? sensor.acc_noise : 0;
  full.gyro_bias_walk = noise ? sensor.gyro_bias_walk : 0;
  full.acc_bias_walk = noise ? sensor.acc_bias_walk : 0;
  full.initial_gyro_bias = noise ? model.initial_gyro_bias : 0;
  full.initial_acc_bias = noise ? model.initial_acc_bias : 0;
  return simulate_imu(motion, begin, duration, full, seed);
}

}  // namespace aslio::simulator
