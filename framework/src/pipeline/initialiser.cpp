#include "aslio/pipeline/initialiser.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/spread.hpp"

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
}

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Averages {
  std::size_t n = 0;
  Vec3 gyro = Vec3::Zero(), acc = Vec3::Zero();
  double acc_std = 0;
};

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

/// Rotation that takes the measured specific force to +z of W with zero yaw.
Mat3 levelled(const Vec3& acc) {
  const Vec3 up_I = acc.normalized();
  const Vec3 axis = up_I.cross(Vec3::UnitZ());
  const double sine = axis.norm();
  const double cosine = up_I.z();
  Mat3 R = sine > 1e-12 ? exp_so3(axis * (std::atan2(sine, cosine) / sine))
           : cosine > 0 ? Mat3(Mat3::Identity())
                        : Mat3(exp_so3(std::numbers::pi * Vec3::UnitX()));
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  return exp_so3(-yaw * Vec3::UnitZ()) * R;
}

/// Steps of a walk: over 0.1 s the mean lies within 6 and 14 m/s^2.
bool may_be_gravity(double norm, bool at_rest) {
  return at_rest ? norm >= 7.0 && norm <= 13.0 : norm >= 3.0 && norm <= 20.0;
}

void refuse_impossible_gravity(double norm, bool at_rest) {
  if (may_be_gravity(norm, at_rest)) return;
  const bool in_g = norm > 0.3 && norm < 2.05;
  throw DataError(fmt::format(
      "initialisation: the mean specific force is {:.3f} m/s^2, which cannot be gravity (9.80665 m/s^2){}", norm,
      in_g ? "; it looks like g: declare 'acc_unit: g' in the sensor file (factor 9.80665)"
           : "; check the acceleration unit of the sensor file, or start at rest"));
}

/// The samples from `begin` on until they reach over `time` [s] and to `until`. Empty while they do not.
std::span<const ImuSample> samples_over(const stream::MeasurementStream& stream, TimeNs begin, double time,
                                        TimeNs until) {
  const auto samples = stream.imu(begin - 1, kTimeMax);
  const auto enough = std::find_if(samples.begin(), samples.end(),
                                   [&](const ImuSample& s) { return s.t >= begin + to_ns(time) && s.t >= until; });
  if (enough == samples.end()) return {};
  const auto used = samples.first(static_cast<std::size_t>(enough - samples.begin()) + 1);
  return used.size() < 2 ? std::span<const ImuSample>{} : used;
}

bool starts_at_rest(const Averages& mean, const InitialisationParams& params) {
  const bool at_rest = mean.acc_std < params.static_acc_std && mean.gyro.norm() < params.static_rate;
  return params.mode == InitialisationMode::static_start || (params.mode == InitialisationMode::automatic && at_rest);
}

Initialisation initialised(std::span<const ImuSample> used, const Averages& mean, bool is_static,
                           const SensorModel& sensor) {
  Initialisation out;
  InitialState& initial = out.initial;
  initial.state.t = used.back().t;
  initial.state.R = levelled(mean.acc);  // eq. INI-1
  if (is_static) {
    initial.mode = InitialMode::static_start;
    initial.state.b_w = mean.gyro;  // eq. INI-2
    const double sample_noise = sensor.gyro_noise / std::sqrt(to_seconds(used.back().t - used.front().t));
    initial.sigma_gyro_bias = std::max(sample_noise, 1e-4);
    initial.sigma_velocity = 0.05;
    initial.sigma_tilt = 0.02;
  } else {
    initial.mode = InitialMode::dynamic_start;
    initial.sigma_tilt = 10.0 * kDegree;
    initial.sigma_gyro_bias = 0.02;
    initial.sigma_velocity = 3.0;
  }
  out.verdict = fmt::format("{} start: |mean rate| {:.4f} rad/s, specific force {:.3f} +- {:.3f} m/s^2 over {} samples",
                            is_static ? "static" : "dynamic", mean.gyro.norm(), mean.acc.norm(), mean.acc_std, mean.n);
  return out;
}

/// At rest in the origin of W, with the axes of I.
Initialisation without_imu(TimeNs t) {
  Initialisation out;
  out.initial.state.t = t;
  out.initial.mode = InitialMode::dynamic_start;
  out.initial.sigma_tilt = std::numbers::pi;
  out.initial.sigma_velocity = 3.0;
  out.verdict = "start without IMU: the world has the axes of the IMU at the first point";
  return out;
}

Mat3 heading(const Mat3& R) { return exp_so3(std::atan2(R(1, 0), R(0, 0)) * Vec3::UnitZ()); }

}  // namespace

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
  const TimeNs begin = std::max(*first_imu, *first_point - to_ns(params.time)) + offset;
  const auto used = samples_over(stream, begin, params.time, *first_point + offset);
  if (used.empty()) return std::nullopt;
  const Averages mean = average(used);
  const bool is_static = starts_at_rest(mean, params);
  refuse_impossible_gravity(mean.acc.norm(), is_static);
  return initialised(used, mean, is_static, sensor);
}

std::optional<Initialisation> initialise_without_imu(const stream::MeasurementStream& stream, TimeNs offset) {
  const auto first_point = stream.first_point();
  if (!first_point) return std::nullopt;
  return without_imu(*first_point - 1 + offset);  // without an offset, the first window holds the first point
}

std::optional<Initialisation> initialise_anew(const stream::MeasurementStream& stream,
                                              const InitialisationParams& params, const SensorModel& sensor,
                                              bool uses_imu, TimeNs lost, const Pose& last) {
  std::optional<Initialisation> out;
  if (!uses_imu) {
    const auto points = stream.points(lost, kTimeMax);
    if (points.empty()) return std::nullopt;
    out = without_imu(points.front().t - 1);
    out->initial.state.R = last.R;
  }
  const auto after = stream.imu(lost, kTimeMax);
  for (TimeNs from = after.empty() ? lost : after.front().t; !out;) {
    const auto used = samples_over(stream, from, params.time, from);
    if (used.empty()) return std::nullopt;
    const Averages mean = average(used);
    const bool is_static = starts_at_rest(mean, params);
    from = used.back().t;
    if (!may_be_gravity(mean.acc.norm(), is_static)) continue;
    out = initialised(used, mean, is_static, sensor);
    out->initial.state.R = heading(last.R) * out->initial.state.R;
  }
  out->initial.state.p = last.p;
  return out;
}

// eq. INI-5.
void recall(InitialState& start, const NavState& reckoned, double blind) {
  constexpr double most_tilt = 20.0 * kDegree;
  if (start.mode != InitialMode::dynamic_start) return;
  const Vec3 up = start.state.R.row(2).transpose(), reckoned_up = -(reckoned.R.transpose() * reckoned.g).normalized();
  const double cosine = up.dot(reckoned_up);
  if (!(cosine > std::cos(most_tilt))) return;
  const TimeNs t = start.state.t;
  start.state = reckoned;
  start.state.t = t;
  start.sigma_velocity = std::min(start.sigma_velocity, 0.3 + 0.1 * blind);
  start.sigma_tilt = std::min(start.sigma_tilt, (1.0 + 0.1 * blind) * kDegree);
  start.sigma_gyro_bias = std::min(start.sigma_gyro_bias, 0.005);
}

}  // namespace aslio::pipeline
