#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/frame_check.hpp"

namespace aslio::experiment {

namespace {

constexpr double kReferenceStep = 0.05;                  // [s] of the poses taken from a dense reference
constexpr double kQuietForce = 0.25, kQuietRate = 0.03;  // [m/s^2], [rad/s] of a second at rest

/// [ns] across which the samples may be interpolated: a few usual steps.
TimeNs largest_gap(std::span<const ImuSample> imu) {
  if (imu.size() < 2) return kSecond / 20;
  const double step = to_seconds(imu.back().t - imu.front().t) / static_cast<double>(imu.size() - 1);
  return std::max(kSecond / 20, to_ns(2.5 * step));
}

/// The reference as stretches of poses, thinned out, over the time of the IMU.
std::vector<evaluation::MotionStretch> stretches_of(const Truth& truth, TimeNs begin, TimeNs end, TimeNs max_gap) {
  std::vector<evaluation::MotionStretch> out;
  evaluation::MotionStretch stretch;
  for (const StampedPose& pose : truth.trajectory.samples()) {
    if (pose.t < begin || pose.t > end) continue;
    if (!stretch.poses.empty()) {
      const TimeNs step = pose.t - stretch.poses.back().t;
      if (step > max_gap)
        out.push_back(std::exchange(stretch, {}));
      else if (step < to_ns(0.9 * kReferenceStep))
        continue;
    }
    stretch.poses.push_back(pose);
  }
  out.push_back(std::move(stretch));
  return out;
}

/// Mean of whole seconds at rest, or of all.
RestForce force_at_rest(std::span<const ImuSample> imu) {
  RestForce rest;
  Vec3 all = Vec3::Zero(), still = Vec3::Zero();
  double still_samples = 0;
  for (std::size_t begin = 0; begin < imu.size();) {
    std::size_t end = begin;
    Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
    double rate = 0;
    for (; end < imu.size() && imu[end].t - imu[begin].t < kSecond; ++end) {
      sum += imu[end].acc;
      squares += imu[end].acc.cwiseAbs2();
      rate += imu[end].gyro.squaredNorm();
    }
    const auto n = static_cast<double>(end - begin);
    all += sum;
    const double spread = std::sqrt(std::max(0.0, (squares / n - (sum / n).cwiseAbs2()).sum()));
    if (end < imu.size() && n >= 5 && spread < kQuietForce && std::sqrt(rate / n) < kQuietRate) {
      still += sum;
      still_samples += n;
      rest.seconds += 1;
    }
    begin = end;
  }
  if (imu.empty()) return rest;
  rest.mean = rest.seconds > 0 ? Vec3(still / still_samples) : Vec3(all / static_cast<double>(imu.size()));
  return rest;
}

evaluation::ForceFitOptions force_options(const evaluation::RotationFit& rotation, const Vec3& expected) {
  evaluation::ForceFitOptions options;
  options.R_I_A = rotation.R_A_B.transpose();
  options.delay = rotation.delay;
  options.gyro_bias = rotation.bias;
  options.gyro_sensitivity = rotation.sensitivity;
  options.gyro_signs = rotation.signs;
  options.expected = expected;
  return options;
}

evaluation::ForceFit force_of(std::span<const evaluation::MotionStretch> a, std::span<const ImuSample> imu,
                              const evaluation::RotationFit& rotation, const Vec3& expected) {
  if (rotation.problem.empty()) return evaluation::fit_force(a, imu, force_options(rotation, expected));
  evaluation::ForceFit none;
  none.problem = "the rotation to the gyro is not known";
  return none;
}

// Of the turns of the LiDAR with the gyro's. Good registrations have 0.999. The fit bears single ones that fail: of a
// walk with 0.8 it was right.
constexpr double kFollowsWell = 0.98, kFollows = 0.7;

void doubt_loose_fit(evaluation::RotationFit& fit) {
  if (!fit.problem.empty() || fit.correlation >= kFollows) return;
  fit.problem = fmt::format(
      "the turns of the LiDAR follow the gyro too loosely (correlation {:.2f}, {:g} needed): its sweeps were not "
      "registered well, by the points alone",
      fit.correlation, kFollows);
}

void measure_reference(FrameMeasurement& m, const Truth& truth, const io::SensorConfig& sensor,
                       const evaluation::TurnSource& gyro) {
  m.has_reference = true;
  m.reference_has_rotation = !truth.positions_only;
  const double max_gap = std::max(0.25, truth.options().max_reference_gap);
  if (!m.reference_has_rotation) {
    evaluation::PointFitOptions point;
    point.expected = sensor.model.T_imu_lidar.inverse() * truth.point;
    point.max_gap = max_gap;
    m.lidar_point = evaluation::fit_point(m.motion.stretches, truth.trajectory, point);
    return;
  }
  const auto stretches = stretches_of(truth, m.motion.imu.front().t, m.motion.imu.back().t, to_ns(max_gap));
  m.gyro_reference = evaluation::fit_rotation(stretches, gyro);
  m.force_reference = force_of(stretches, m.motion.imu, m.gyro_reference, Vec3::Zero());
  evaluation::HandEyeOptions options;
  options.expected = sensor.model.T_imu_lidar;
  options.start = options.expected.R;
  options.max_gap = max_gap;
  if (m.gyro_lidar.problem.empty() && m.gyro_reference.problem.empty()) {
    options.start = m.gyro_reference.R_A_B * m.gyro_lidar.R_A_B.transpose();
    options.delay = m.gyro_lidar.delay - m.gyro_reference.delay;
  }
  m.lidar_reference = evaluation::fit_hand_eye(m.motion.stretches, truth.trajectory, options);
  if (m.rest.seconds > 0 && m.force_reference.problem.empty()) {
    m.rest.tilt = std::acos(std::clamp(m.force_reference.up.z(), -1.0, 1.0));
  }
}

/// Whether nearly all turns are those of a car.
bool turns_slowly(std::span<const ImuSample> imu) {
  constexpr double kSlow = 0.6, kNearlyAll = 0.95;  // [rad/s]
  std::vector<double> rates;
  for (const ImuSample& sample : imu) rates.push_back(sample.gyro.norm());
  const auto at = rates.begin() + static_cast<std::ptrdiff_t>(kNearlyAll * static_cast<double>(rates.size()));
  if (at == rates.end()) return false;
  std::nth_element(rates.begin(), at, rates.end());
  return *at < kSlow;
}

/// Throws DataError where there is nothing to compare.
void read_motion(FrameMeasurement& m, const LidarMotionOptions& options, const plugin::Catalog& catalog,
                 RunMonitor& monitor) {
  m.motion = read_lidar_motion(options, catalog, monitor);
  const std::string input = options.inputs.front().string();
  if (m.motion.imu.empty()) {
    throw DataError(fmt::format("{}: no IMU sample was read: nothing to compare the LiDAR with", input));
  }
  if (m.motion.stretches.empty() && !m.motion.interrupted) {
    throw DataError(
        fmt::format("{}: no stretch of 1.5 s could be registered ({} of {} windows in {:.1f} s): give a "
                    "longer section, or check min_range and sweep_period of the sensor file",
                    input, m.motion.accepted, m.motion.windows, m.motion.data_s));
  }
  const evaluation::GyroTurns gyro(m.motion.imu, largest_gap(m.motion.imu));
  evaluation::RotationFitOptions rotation;
  rotation.expected = options.sensor.model.T_imu_lidar.R.transpose();
  m.gyro_lidar = evaluation::fit_rotation(m.motion.stretches, gyro, rotation);
  doubt_loose_fit(m.gyro_lidar);
}

}  // namespace

FrameCheck check_frames(const FrameCheckOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor) {
  const io::SensorConfig& sensor = options.motion.sensor;
  std::optional<Truth> truth;
  if (options.reference) truth.emplace(load_truth(*options.reference, &sensor));
  FrameMeasurement m;
  read_motion(m, options.motion, catalog, monitor);
  const bool follows = m.gyro_lidar.problem.empty() && m.gyro_lidar.correlation >= kFollowsWell;
  if (!follows && !m.motion.interrupted && options.slow_overrides && turns_slowly(m.motion.imu)) {
    LidarMotionOptions slow = options.motion;
    slow.overrides = *options.slow_overrides;
    try {
      FrameMeasurement again;
      read_motion(again, slow, catalog, monitor);
      if (again.gyro_lidar.correlation > m.gyro_lidar.correlation) m = std::move(again);
    } catch (const DataError&) {
      // Nothing could be registered: what was measured before stands.
    }
  }
  m.force_lidar = force_of(m.motion.stretches, m.motion.imu, m.gyro_lidar, sensor.model.T_imu_lidar.p);
  m.rest = force_at_rest(m.motion.imu);
  if (truth) {
    const evaluation::GyroTurns gyro(m.motion.imu, largest_gap(m.motion.imu));
    measure_reference(m, *truth, sensor, gyro);
  }
  return judge_frames(std::move(m), sensor, truth ? &*truth : nullptr, options.published);
}

}  // namespace aslio::experiment
