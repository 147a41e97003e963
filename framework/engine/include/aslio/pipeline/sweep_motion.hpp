#pragma once
/// The motion over the first sweeps of a recording, found by registering them (docs/equations.md INI-6).

#include <algorithm>
#include <optional>
#include <span>

#include "aslio/core/sensor.hpp"
#include "aslio/core/types.hpp"

namespace aslio::pipeline {

/// What the first sweeps say. All vectors have the axes of I at the begin.
struct SweepMotion {
  Vec3 velocity = Vec3::Zero();  ///< of I at the begin [m/s]
  Vec3 rate = Vec3::Zero();      ///< part of the rate that the gyro does not give; without IMU data all of it [rad/s]
  Vec3 gravity = Vec3::Zero();   ///< [m/s^2]; zero without IMU data
  double sigma_velocity = 0;     ///< standard deviation in the worst direction [m/s]
  double sigma_tilt = 0;         ///< of the direction of gravity [rad]
  double fit = 0;                ///< how well the next sweep, which took no part, agrees: 0 not at all, 1 fully
  double fit_at_rest = 0;        ///< the same had the sensor not moved
  /// The points show a motion: no rest explains the sweeps as well.
  bool moves = false;
  /// The first sweeps share enough of the view to say anything, also of a rest.
  bool shares = false;
  /// They do, the next sweep agrees with the motion, the points bind it, and no rate of turn contradicts the gyro.
  bool believed = false;
  /// Another motion, more than 1.2 m per sweep apart, explains the sweeps nearly as well.
  bool ambiguous = false;
  /// The rate differs from that of the gyro by more than any bias.
  bool contradicts_gyro = false;
};

/// Sweeps that are registered with the first one, and one to check the result.
inline constexpr int kSweepsOfMotion = 4;

/// Time of points that count as a sweep here [s]: a sweep of the sensor, and at least 0.1 s. In less a slow sensor
/// carrier hardly moves, and few points are seen.
inline double sweep_motion_step(const SensorModel& sensor) { return std::max(0.1, sensor.sweep_period); }

/// Data after the begin that find_sweep_motion() needs [ns].
inline TimeNs sweep_motion_span(const SensorModel& sensor) {
  return kSweepsOfMotion * to_ns(sweep_motion_step(sensor));
}

/// Registers the sweeps of (begin, begin + sweep_motion_span()] with each other: coarse to fine, from several
/// hypotheses of a speed of up to 40 m/s. `points`: raw points of that time; `imu`: samples that cover it, the first at
/// `begin`; empty without an IMU. Nothing when a sweep has too few points. Same input, same bits. Costs some 0.2 s.
std::optional<SweepMotion> find_sweep_motion(std::span<const TimedPoint> points, std::span<const ImuSample> imu,
                                             TimeNs begin, const SensorModel& sensor);

}  // namespace aslio::pipeline
