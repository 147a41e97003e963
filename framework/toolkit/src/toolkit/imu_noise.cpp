#include "aslio/toolkit/imu_noise.hpp"

#include <algorithm>
#include <cmath>

namespace aslio {

UnreadMotion::UnreadMotion(TimeNs gap) {
  constexpr double longest = 0.4;              // [s]
  constexpr double jerk = 12.5, swerve = 5.0;  // [m/s^3], [rad/s^2]: what a line between two readings is off per time
  const double unread = std::min(to_seconds(gap), longest);
  gyro = std::pow(swerve * unread, 2) * unread;
  acc = std::pow(jerk * unread, 2) * unread;
}

void UnresolvedMotion::observe(const Window& window) {
  const auto& imu = window.imu;
  if (window.imu_gap > 0) readings_ = 0;
  // The first one ended the window before; the last one may be interpolated.
  for (std::size_t i = 1; i + 1 < imu.size(); ++i) read(imu[i]);
  if (imu.size() > 1 && window.imu_read_at_end) read(imu.back());
}

void UnresolvedMotion::read(const ImuSample& reading) {
  constexpr double fast_enough = 0.02;  // [s]: beyond 50 Hz a body and its filter follow the samples
  constexpr double memory = 1.0;        // [s]
  constexpr double uneven = 2.0;        // beyond, noise would count for more than motion
  if (reading.t <= newest_) return;
  newest_ = reading.t;
  if (reading.faults != 0) {
    readings_ = 0;
    return;
  }
  if (readings_ == 2) {
    const double before = to_seconds(last_[1].t - last_[0].t), after = to_seconds(reading.t - last_[1].t);
    const bool even = std::max(before, after) < uneven * std::min(before, after);
    if (even && std::min(before, after) >= fast_enough) {
      const double period = 0.5 * (before + after), share = 1.0 - std::exp(-after / memory);
      const auto density = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3 second_difference = period * ((c - b) / after - (b - a) / before);
        return period * second_difference.squaredNorm() / (3.0 * 12.0);
      };
      density_.gyro += share * (density(last_[0].gyro, last_[1].gyro, reading.gyro) - density_.gyro);
      density_.acc += share * (density(last_[0].acc, last_[1].acc, reading.acc) - density_.acc);
    }
  }
  last_ = {last_[1], reading};
  readings_ = std::min<std::size_t>(readings_ + 1, 2);
}

DoubtedMotion::DoubtedMotion(const ImuSample& from, const ImuSample& to) : any((from.faults | to.faults) != 0) {
  if (!any) return;
  const int faults = from.faults | to.faults;
  const UnreadMotion unread(kSecond / 5);
  // What is beyond a range is not known: as much again as a usual one has, for the time of a throw or a step.
  constexpr double throw_rate = 4.0, throw_time = 0.1;     // [rad/s], [s]
  constexpr double shock_force = 10.0, shock_time = 0.02;  // [m/s^2], [s]
  if ((faults & imu_fault::gyro_dead) != 0) gyro.array() += unread.gyro;
  if ((faults & imu_fault::acc_dead) != 0) acc.array() += unread.acc;
  for (int axis = 0; axis < 3; ++axis) {
    if ((faults & imu_fault::clipped(false, axis)) != 0) gyro[axis] += throw_rate * throw_rate * throw_time;
    if ((faults & imu_fault::clipped(true, axis)) != 0) acc[axis] += shock_force * shock_force * shock_time;
  }
}

ImuNoise ImuNoisePreset::over(const ImuSample& from, const ImuSample& to, const SensorModel& sensor, const Vec3& b_w,
                              const Circumstances& how) const {
  const double dt = std::max(to_seconds(to.t - from.t), 1e-6);
  ImuNoise noise{0.1, 0.1, 1e-4, 1e-4};  // as published, gaps or not
  if (kind != Kind::fastlio) {
    noise = of_readings(from, to, sensor, b_w, how.degenerate);
    noise.gyro += how.unresolved.gyro / dt;
    noise.acc += how.unresolved.acc / dt;
    if (how.imu_gap > 0) {
      const UnreadMotion unread(how.imu_gap);
      noise.gyro += unread.gyro / dt;
      noise.acc += unread.acc / dt;
    }
  }
  if (const DoubtedMotion doubted(from, to); doubted.any) {
    noise.gyro_axes = doubted.gyro / dt;
    noise.acc_axes = doubted.acc / dt;
  }
  return noise;
}

ImuNoise ImuNoisePreset::of_readings(const ImuSample& from, const ImuSample& to, const SensorModel& sensor,
                                     const Vec3& b_w, bool degenerate) const {
  const double dt = std::max(to_seconds(to.t - from.t), 1e-6);
  const auto discrete = [dt](double density) { return density * density / dt; };
  const double acc = degenerate ? std::max(sensor.acc_noise, degenerate_acc_noise) : sensor.acc_noise;
  ImuNoise noise{discrete(sensor.gyro_noise), discrete(acc), discrete(sensor.gyro_bias_walk),
                 discrete(sensor.acc_bias_walk)};
  if (kind == Kind::rate_scaled) {
    // eq. MOT-5: a scale error of 1 % and a delay of 3 ms, correlated over 0.1 s.
    constexpr double scale = 0.01, delay = 0.003, correlation = 0.1;
    const Vec3 rate = 0.5 * (from.gyro + to.gyro) - b_w;
    const Vec3 change = (to.gyro - from.gyro) / dt;
    noise.gyro += (scale * scale * rate.squaredNorm() + delay * delay * change.squaredNorm()) * correlation / dt;
  }
  return noise;
}

}  // namespace aslio
