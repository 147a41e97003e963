#pragma once

#include <vector>

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/motion.hpp"

namespace aslio::simulator {

/// Through (x, y) at `t` with the given velocity, without acceleration or jerk there.
struct Waypoint {
  double t = 0, x = 0, y = 0, vx = 0, vy = 0;
};
/// Heading changes by `angle` within [begin, begin + duration]; peak rate 2.1875 angle / duration.
struct Turn {
  double begin = 0, duration = 1, angle = 0;  ///< [s], [s], [rad]
  double roll = 0, pitch = 0;                 ///< lean in its middle [rad]
  bool glance = false;                        ///< of the head alone: the way goes on
};
/// One oscillation of all three angles.
struct Tremor {
  double frequency = 10;          ///< [Hz]
  Vec3 amplitude = Vec3::Zero();  ///< of roll, pitch and yaw [rad]
  Vec3 phase = Vec3::Zero();      ///< at time 0 [rad]
};
/// Steps of a walking person: vertical motion, roll and pitch. Amplitudes vanish at both ends of the walk.
struct Gait {
  double frequency = 1.8;    ///< steps per second [Hz]
  double height = 0.015;     ///< amplitude at `frequency`, 30 % of it at the double [m]
  double roll = 0.02;        ///< amplitude at half the frequency [rad]
  double pitch = 0.015;      ///< amplitude at the frequency [rad]
  double fade = 1;           ///< time in which the amplitudes rise and fall [s]
  double phase = 0;          ///< of `frequency` at time 0 [rad]; the others go with it
  double heel = 0;           ///< peak of the vertical acceleration when a foot meets the ground [m/s^2]
  double heel_time = 0.015;  ///< standard deviation of the jolt [s]
  double sway = 0;           ///< amplitude from side to side, at half the frequency [m]
  std::vector<Tremor> tremor = {};
};
/// What a walk over a route adds to its line.
struct WalkSetting {
  Ground ground;           ///< that the line follows
  double height = 0;       ///< of the IMU above the ground [m]
  double heading = 0;      ///< before the first turn [rad]
  double rest = 0;         ///< time after the last waypoint that belongs to the walk [s]
  bool under_way = false;  ///< the walk begins at the first waypoint's velocity, with the gait at full amplitude
};

/// Three times continuously differentiable motion: septic polynomials between waypoints and for turns, plus gait. The
/// jolt of a heel is a Gaussian of time, as a Fourier series over the steps.
/// Euler angles ZYX. At rest before the first (unless under way: then at constant velocity) and after the last
/// waypoint.
class Walk final : public Motion {
 public:
  /// Waypoints in ascending time, at rest at both ends. `time_scale` slows everything but the gait's frequency.
  Walk(std::vector<Waypoint> waypoints, std::vector<Turn> turns, const Gait& gait, double time_scale);
  /// Waypoints in ascending time, at rest at the last one and, unless under way, at the first.
  Walk(std::vector<Waypoint> waypoints, std::vector<Turn> turns, const Gait& gait, WalkSetting setting);

  /// Motion `t` seconds after the start.
  MotionState at(double t) const override;
  double duration() const override;

 private:
  struct Gaited;  ///< displacements of one time
  /// What jolts, sway and tremor add at `t` to height, side and angles.
  Gaited body(double t) const;

  std::vector<Waypoint> waypoints_;
  std::vector<Turn> turns_;           ///< by their begin
  std::vector<Turn> glances_;         ///< those of the head alone
  std::vector<double> all_over_;      ///< [k]: turns 0..k are over from this time on
  std::vector<double> angle_before_;  ///< [k]: sum of the angles of the turns before k
  Gait gait_;
  bool has_body_ = false;     ///< there are jolts, sway or tremor
  std::vector<double> jolt_;  ///< [n]: amplitude of the height at n + 1 times the frequency [m]
  double time_scale_ = 1;
  WalkSetting setting_;
};

}  // namespace aslio::simulator
