#include "aslio/pipeline/initialiser.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/spread.hpp"
#include "imu_at_start.hpp"
#include "imu_gap.hpp"

namespace aslio::pipeline {

void InitialisationParams::describe(config::Binder& b, InitialisationParams& p) {
  b.choice("mode", p.mode,
           {{"auto", InitialisationMode::automatic},
            {"static", InitialisationMode::static_start},
            {"dynamic", InitialisationMode::dynamic_start}},
           "whether the recording starts at rest; auto decides by the IMU data");
  b.real("time", p.time, "s", {.above = 0, .max = 60}, "IMU data averaged, at least two samples");
  b.real("static_acc_std", p.static_acc_std, "m/s^2", {.above = 0, .max = 10},
         "auto: at rest when the specific force varies less than this");
  b.real("static_rate", p.static_rate, "rad/s", {.above = 0, .max = 10}, "auto: and the mean turn rate is below this");
  b.flag("register_sweeps", p.register_sweeps,
         "auto and dynamic: registers the first sweeps, to prove a rest or to find the first velocity; false: the IMU "
         "decides, and the first updates find the velocity");
  b.flag(
      "scale_specific_force", p.scale_specific_force,
      "multiplies the accelerometer's readings by g / |their mean at the start| (FAST-LIO2); a start in motion scales "
      "by what the motion adds");
}

namespace {

/// Rotation that takes the measured specific force to +z of W with zero yaw.
Mat3 levelled(const Vec3& acc) {
  const Mat3 R = to_vertical(acc);
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  return exp_so3(-yaw * Vec3::UnitZ()) * R;
}

void refuse_impossible_gravity(double norm, bool at_rest) {
  if (may_be_gravity(norm, at_rest)) return;
  const bool in_g = norm > 0.3 && norm < 2.05;
  throw DataError(fmt::format(
      "initialisation: the mean specific force is {:.3f} m/s^2, which cannot be gravity (9.80665 m/s^2){}", norm,
      in_g ? "; it looks like g: declare 'acc_unit: g' in the sensor file (factor 9.80665)"
           : "; check the acceleration unit of the sensor file, or start at rest"));
}

/// In motion nothing of the IMU's bias is known, nor of the velocity. eq. INI-2
void release_velocity(InitialState& initial) {
  initial.mode = InitialMode::dynamic_start;
  initial.state.b_w.setZero();
  initial.sigma_tilt = 10.0 * kRadPerDeg;
  initial.sigma_gyro_bias = 0.02;
  initial.sigma_velocity = 3.0;
}

bool is_dead(const ImuSample& s) { return (s.faults & (imu_fault::gyro_dead | imu_fault::acc_dead)) != 0; }

/// An IMU that has read nothing for far longer than one that starts up, or at all.
void refuse_dead_imu(const stream::MeasurementStream& stream, double time) {
  constexpr double starts_up = 2.0;  // [s]
  const auto all = stream.imu(kTimeMin, kTimeMax);
  const double enough = stream.finished() ? time : time + starts_up;
  if (all.size() < 2 || all.back().t - all.front().t < to_ns(enough) || !std::all_of(all.begin(), all.end(), is_dead))
    return;
  throw DataError(
      fmt::format("initialisation: the IMU is dead: all {} samples of its first {:.2f} s are zero, gravity included. "
                  "Check its cable and driver, or use a pipeline without IMU (kiss_icp)",
                  all.size(), to_seconds(all.back().t - all.front().t)));
}

}  // namespace

Averages average(std::span<const ImuSample> samples) {
  Averages out;
  out.n = samples.size();
  for (const ImuSample& s : samples) {
    out.gyro += s.gyro;
    out.acc += s.acc;
  }
  out.gyro /= static_cast<double>(out.n);
  out.acc /= static_cast<double>(out.n);
  double squares = 0;
  for (const ImuSample& s : samples) squares += (s.acc - out.acc).squaredNorm();
  out.acc_std = std::sqrt(squares / static_cast<double>(out.n));
  return out;
}

std::span<const ImuSample> samples_over(const stream::MeasurementStream& stream, TimeNs begin, TimeNs end, double time,
                                        TimeNs until) {
  const auto samples = stream.imu(begin - 1, end);
  if (samples.empty()) return {};
  // From the second on: the first of a slow IMU may reach that far alone.
  const auto enough = std::find_if(samples.begin() + 1, samples.end(),
                                   [&](const ImuSample& s) { return s.t >= begin + to_ns(time) && s.t >= until; });
  if (enough == samples.end()) return {};
  return samples.first(static_cast<std::size_t>(enough - samples.begin()) + 1);
}

bool is_at_rest(const Averages& mean, const InitialisationParams& params) {
  return mean.acc_std < params.static_acc_std && mean.gyro.norm() < params.static_rate;
}

bool may_be_gravity(double norm, bool at_rest) {
  return at_rest ? norm >= 7.0 && norm <= 13.0 : norm >= 3.0 && norm <= 20.0;
}

Mat3 to_vertical(const Vec3& up) {
  const Vec3 from = up.normalized();
  const Vec3 axis = from.cross(Vec3::UnitZ());
  const double sine = axis.norm();
  const double cosine = from.z();
  return sine > 1e-12 ? exp_so3(axis * (std::atan2(sine, cosine) / sine))
         : cosine > 0 ? Mat3(Mat3::Identity())
                      : Mat3(exp_so3(std::numbers::pi * Vec3::UnitX()));
}

Initialisation start_of(std::span<const ImuSample> used, const Averages& mean, bool is_static,
                        const SensorModel& sensor) {
  Initialisation out;
  InitialState& initial = out.initial;
  initial.state.t = used.back().t;
  out.mean_force = mean.acc.norm();
  if (is_static) {
    initial.mode = InitialMode::static_start;
    initial.state.b_w = mean.gyro;  // eq. INI-2
    const double sample_noise = sensor.gyro_noise / std::sqrt(to_seconds(used.back().t - used.front().t));
    initial.sigma_gyro_bias = std::max(sample_noise, 1e-4);
    initial.sigma_velocity = 0.05;
    initial.sigma_tilt = 0.02;
  } else {
    release_velocity(initial);
  }
  out.verdict = fmt::format("{} start: |mean rate| {:.4f} rad/s, specific force {:.3f} +- {:.3f} m/s^2 over {} samples",
                            is_static ? "static" : "dynamic", mean.gyro.norm(), mean.acc.norm(), mean.acc_std, mean.n);
  return out;
}

Initialisation start_without_imu(TimeNs t) {
  Initialisation out;
  out.initial.state.t = t;
  out.initial.mode = InitialMode::dynamic_start;
  out.initial.sigma_tilt = std::numbers::pi;
  out.initial.sigma_velocity = 3.0;
  out.verdict = "start without IMU: the world has the axes of the IMU at the first point";
  return out;
}

TimeNs start_offset(std::uint64_t order_seed) {
  constexpr std::uint64_t kLongest = 100'000'000;  // a sweep of most sensors
  return static_cast<TimeNs>((((order_seed * kGoldenRatio) >> 32U) * kLongest) >> 32U);
}

std::optional<Initialisation> initialise(const stream::MeasurementStream& stream, const InitialisationParams& params,
                                         const SensorModel& sensor, TimeNs offset) {
  const auto first_point = stream.first_point();
  const auto first_imu = stream.first_imu();
  if (!first_point || !first_imu) return std::nullopt;
  // IMU data before the first point serves as well, when there is some.
  const auto samples_from = [&](TimeNs begin) {
    return samples_over(stream, begin + offset, kTimeMax, params.time, *first_point + offset);
  };
  auto used = samples_from(std::max(*first_imu, *first_point - to_ns(params.time)));
  refuse_dead_imu(stream, params.time);
  while (!used.empty()) {
    // What was measured before a gap says nothing of after, and what a dead sensor reads says nothing at all.
    const auto gap = std::adjacent_find(used.begin(), used.end(), is_gap);
    const auto dead = std::find_if(used.begin(), used.end(), is_dead);
    if (gap == used.end() && dead == used.end()) break;
    used = samples_from(gap != used.end() ? std::next(gap)->t : dead->t + 1);
  }
  if (used.empty()) return std::nullopt;
  const Averages mean = average(used);
  const bool is_static = params.mode == InitialisationMode::static_start ||
                         (params.mode == InitialisationMode::automatic && is_at_rest(mean, params));
  refuse_impossible_gravity(mean.acc.norm(), is_static);
  Initialisation out = start_of(used, mean, is_static, sensor);
  out.initial.state.R = levelled(mean.acc);  // eq. INI-1
  return out;
}

namespace {

std::string what_sweeps_say(const SweepMotion& motion) {
  return fmt::format("first sweeps: {:.2f} +- {:.2f} m/s, agreement {:.2f}, at rest {:.2f}", motion.velocity.norm(),
                     motion.sigma_velocity, motion.fit, motion.fit_at_rest);
}

}  // namespace

void doubt_declared_rest(Initialisation& found, const SweepMotion& motion) {
  found.verdict += fmt::format("; {}", what_sweeps_say(motion));
  if (!motion.moves) return;
  found.doubt =
      fmt::format("initialisation.mode is 'static', but the first sweeps show a motion of {:.1f} m/s: take 'auto'",
                  motion.velocity.norm());
}

void apply_sweep_motion(Initialisation& found, const SweepMotion& motion, const Mat3* heading) {
  InitialState& initial = found.initial;
  const bool static_by_imu = initial.mode == InitialMode::static_start;
  const std::string seen = what_sweeps_say(motion);
  if (motion.ambiguous) {
    found.doubt = fmt::format(
        "the first velocity is not certain: {:.1f} m/s is used, another one explains the first sweeps nearly as well",
        motion.velocity.norm());
  }
  const bool without_imu = motion.gravity.squaredNorm() == 0;
  // Sweeps that bind no velocity, of a bare road say, prove no rest.
  constexpr double proves = 0.7;  // [m/s]; rests in rooms and streets have up to 0.35
  const bool bound = motion.sigma_velocity < proves;
  if ((static_by_imu || without_imu) && !motion.moves && bound && motion.shares) {
    found.verdict += fmt::format("; {}: at rest", seen);
    return;
  }
  if (!motion.believed || (!motion.moves && !bound)) {
    if (static_by_imu) release_velocity(initial);
    found.verdict += fmt::format("; {}: velocity not known", seen);
    found.doubt =
        "the first velocity is not known: the first sweeps " +
        (motion.contradicts_gyro
             ? fmt::format("contradict the gyro by {:.2f} rad/s: check gyro_unit and T_imu_lidar", motion.rate.norm())
         : !motion.shares ? std::string("share too little of the view")
         : bound          ? std::string("do not agree on one")
                          : std::string("do not bind it"));
    return;
  }
  if (static_by_imu) release_velocity(initial);
  initial.mode = InitialMode::moving_start;
  initial.rate = motion.rate;
  initial.sigma_velocity = std::max(0.1, 1.5 * motion.sigma_velocity);
  const double sigma_tilt = std::clamp(motion.sigma_tilt, 1.0 * kRadPerDeg, 10.0 * kRadPerDeg);
  if (!without_imu && sigma_tilt < initial.sigma_tilt) {
    const Vec3 up = -motion.gravity;
    initial.state.R = heading == nullptr ? levelled(up) : Mat3(to_vertical(*heading * up) * *heading);
    initial.sigma_tilt = sigma_tilt;
  }
  initial.state.v = initial.state.R * motion.velocity;
  found.verdict += fmt::format("; {}: in motion", seen);
}

std::optional<Initialisation> initialise_without_imu(const stream::MeasurementStream& stream, TimeNs offset) {
  const auto first_point = stream.first_point();
  if (!first_point) return std::nullopt;
  return start_without_imu(*first_point - 1 + offset);  // without an offset, the first window holds the first point
}

}  // namespace aslio::pipeline
