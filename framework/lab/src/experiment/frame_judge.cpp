#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "aslio/core/angles.hpp"
#include "aslio/experiment/frame_check.hpp"
#include "frame_difference.hpp"

namespace aslio::experiment {

namespace {

// Axes of a gyro of MEMS stand within 0.5 % by their data sheets, two of them per rotation, evenly spread.
constexpr double kGyroAxes = 0.12 * kRadPerDeg, kGyroAxesCalibrated = 0.03 * kRadPerDeg;
constexpr double kPoseAxes = 0.03 * kRadPerDeg;  // of poses: registration leans a little with the scene
// [m] of a lever arm: by specific force and an exact path, by that and the LiDAR, by poses. Registration of single
// sweeps leans with the swing of the sensor.
constexpr double kForceFloor = 0.004, kLidarForceFloor = 0.015, kPoseFloor = 0.002;
constexpr double kTurnTolerated = 0.2 * kRadPerDeg, kShiftTolerated = 0.005;
constexpr double kDelayFloor = 0.0003, kDelayTolerated = 0.003;  // [s]: filters of an IMU delay it by 2 ms
constexpr double kDelayRate = 50;  // [Hz] of an IMU that can tell a delay: below, its turns are drawn between samples
constexpr double kPointFloor = 0.005, kPointTolerated = 0.01;        // [m] of a reference point
constexpr double kPointDelayTolerated = 0.01;                        // [s] of its positions
constexpr double kStampTolerated = 0.008;                            // [s] of a whole or half sweep
constexpr double kTurnBound = 1.0 * kRadPerDeg, kShiftBound = 0.05;  // standard deviations of what counts as known
constexpr double kAxesMost = 1.5 * kRadPerDeg, kAxesAlike = 0.15 * kRadPerDeg;  // that a gyro's own axes are off

class Judge {
 public:
  Judge(FrameCheck& check, const io::SensorConfig& sensor, const Truth* truth)
      : check_(check), m_(check.measurement), sensor_(sensor), truth_(truth) {}

  void run() {
    axes_of_gyro_off_ = gyro_axes_are_off();
    turned_ = lidar_is_turned();
    judge_signs();
    sign_is_wrong_ = !turned_ && check_.contradicts();
    if (!turned_) judge_gyro_lidar();
    judge_clocks();
    judge_rest();
    if (!turned_) judge_force_lidar();
    if (m_.has_reference) judge_reference();
    if (!m_.has_reference) {
      say(FindingKind::undetermined, "reference", "there is none: T_imu_reference, its lever arm and its clock");
    }
    fuse();
    name_extrinsic();
  }

 private:
  void say(FindingKind kind, std::string subject, std::string text, std::string key = {}, std::string value = {}) {
    check_.findings.push_back({kind, std::move(subject), std::move(text), std::move(key), std::move(value)});
  }

  /// LiDAR and reference agree about T_imu_lidar, and the gyro is turned against both alike: its own axes are.
  bool gyro_axes_are_off() const {
    const auto &lidar = m_.gyro_lidar, &reference = m_.gyro_reference;
    if (!m_.reference_has_rotation || !lidar.problem.empty() || !reference.problem.empty()) return false;
    if (!m_.lidar_reference.problem.empty() || reference.turns == 0) return false;
    const Mat3& declared = sensor_.model.T_imu_lidar.R;
    const Vec3 by_lidar = log_so3(lidar.R_A_B.transpose() * declared.transpose());
    const Vec3 by_reference = log_so3(reference.R_A_B.transpose());
    const Vec3 between = log_so3(m_.lidar_reference.T_B_A.R * declared.transpose());
    return (by_lidar - by_reference).norm() < kAxesAlike && by_lidar.norm() < kAxesMost && between.norm() < kAxesAlike;
  }

  double gyro_axes() const { return sensor_.gyro_sensitivity.isZero(0) ? kGyroAxes : kGyroAxesCalibrated; }

  /// "axis x measures", "axes x and y measure".
  static std::string reversed_axes(const Vec3& signs) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      if (signs[i] < 0) text += std::string(text.empty() ? "" : " and ") + kAxis[static_cast<std::size_t>(i)];
    }
    const bool one = (signs.array() < 0).count() == 1;
    return fmt::format("{} {} {}", one ? "axis" : "axes", text, one ? "measures" : "measure");
  }

  static std::string signs_value(const std::array<double, 3>& now, const Vec3& found) {
    return fmt::format("[{:g}, {:g}, {:g}]", now[0] * found[0], now[1] * found[1], now[2] * found[2]);
  }

  /// Two reversed axes are half a turn: of the LiDAR where something else finds no fault with the gyro, or the same
  /// with the accelerometer.
  bool lidar_is_turned() const {
    const auto &lidar = m_.gyro_lidar, &reference = m_.gyro_reference;
    if (!lidar.problem.empty() || lidar.signs.sum() != -1) return false;
    const bool by_reference = m_.reference_has_rotation && reference.problem.empty() && reference.turns > 0;
    if (by_reference) return (reference.signs.array() > 0).all();
    const auto& force = m_.force_lidar;
    return force.problem.empty() && force.pieces > 0 && force.signs == lidar.signs;
  }

  void say_turned_lidar() {
    const auto& fit = m_.gyro_lidar;
    const Pose& declared = sensor_.model.T_imu_lidar;
    const Mat3 R = fit.signs.asDiagonal() * fit.R_A_B.transpose();
    say(FindingKind::contradicts, "LiDAR against gyro",
        fmt::format("the rotation of T_imu_lidar is off by {:.0f} deg{}",
                    kDegPerRad * log_so3(R * declared.R.transpose()).norm(),
                    declared.R.isIdentity(0) ? ": the files have none" : ""),
        "T_imu_lidar", pose_of({R, declared.p}));
    say(FindingKind::undetermined, "accelerometer signs", "and the lever arm: check again with the right rotation");
  }

  void judge_signs() {
    if (turned_) return say_turned_lidar();
    const auto& rotation = m_.gyro_lidar;
    if (!rotation.problem.empty()) {
      // Poses of a reference know the signs as well.
      if (m_.gyro_reference.turns == 0) {
        return say(FindingKind::undetermined, "gyro signs", "not compared with the LiDAR: " + rotation.problem);
      }
    }
    const auto& fit = rotation.problem.empty() ? rotation : m_.gyro_reference;
    const Vec3& gyro = fit.signs;
    if ((gyro.array() > 0).all()) {
      say(FindingKind::agrees, "gyro signs", fmt::format("no axis is reversed; correlation {:.3f}", fit.correlation));
    } else {
      const bool two = gyro.sum() == -1;
      say(FindingKind::contradicts, "gyro signs",
          fmt::format("{} the other way round{}", reversed_axes(gyro),
                      two ? "; or T_imu_lidar is off by half a turn about the other axis" : ""),
          "gyro_signs", signs_value(sensor_.gyro_signs, gyro));
    }
    judge_acc_signs();
  }

  void judge_acc_signs() {
    const auto& by_reference = m_.force_reference;
    const auto& force = m_.force_lidar.problem.empty() ? m_.force_lidar : by_reference;
    if (force.pieces == 0 || !force.problem.empty()) {
      return say(FindingKind::undetermined, "accelerometer signs", "not known: " + m_.force_lidar.problem);
    }
    Vec3 signs = force.signs, known = Vec3::Zero();
    std::string open, scales;
    for (int i = 0; i < 3; ++i) {
      // The sharper of both tells.
      const bool other =
          by_reference.problem.empty() && by_reference.pieces > 0 && by_reference.sigma_scale[i] < force.sigma_scale[i];
      const auto& sharp = other ? by_reference : force;
      signs[i] = sharp.signs[i];
      known[i] = sharp.sigma_scale[i] < 0.25 ? 1 : 0;
      if (known[i] == 0) open += std::string(open.empty() ? "" : " and ") + kAxis[static_cast<std::size_t>(i)];
      scales += fmt::format("{}{} {:+.2f} +- {:.2f}", i == 0 ? "" : ", ", kAxis[static_cast<std::size_t>(i)],
                            sharp.scale[i], sharp.sigma_scale[i]);
    }
    if ((signs.array() < 0).any()) {
      return say(FindingKind::contradicts, "accelerometer signs",
                 fmt::format("{} the other way round; scale against the motion: {}", reversed_axes(signs), scales),
                 "acc_signs", signs_value(sensor_.acc_signs, signs));
    }
    if (!known.isZero()) {
      say(FindingKind::agrees, "accelerometer signs", "no axis is reversed; scale against the motion: " + scales);
    }
    if (!open.empty()) {
      say(FindingKind::undetermined, "accelerometer signs", "of " + open + ": too little acceleration along it");
    }
  }

  void judge_gyro_lidar() {
    const auto& fit = m_.gyro_lidar;
    if (!fit.problem.empty()) {
      const bool degrees = std::abs(std::abs(std::log(fit.ratio)) - std::log(kDegPerRad)) < 0.2;
      // A registration that failed looks the same, but for the factor of a unit, or where a reference says so, too.
      const bool wrong = fit.unlike && (degrees || m_.gyro_reference.unlike);
      const std::string text = fit.unlike && !wrong ? fit.problem + "; or the registration failed" : fit.problem;
      return say(wrong ? FindingKind::contradicts : FindingKind::undetermined, "LiDAR against gyro", text,
                 degrees ? "gyro_unit" : "", degrees ? (fit.ratio > 1 ? "deg_s" : "rad_s") : "");
    }
    const Mat3 R = fit.R_A_B.transpose();  // R_I_L
    const Mat3 floor = gyro_axes() * gyro_axes() * Mat3::Identity();
    gyro_covariance_ = R * fit.covariance * R.transpose() + floor;
    gyro_turn_ = log_so3(R * sensor_.model.T_imu_lidar.R.transpose());
    const Difference d = difference(gyro_turn_, gyro_covariance_, kTurnBound, kTurnTolerated);
    if (d.contradicts && axes_of_gyro_off_) return say_gyro_axes(d);
    report_rotation(d, "LiDAR against gyro", "T_imu_lidar", Pose{R, sensor_.model.T_imu_lidar.p});
  }

  void say_gyro_axes(const Difference& d) {
    say(FindingKind::note, "gyro",
        fmt::format("its axes are off by {:.2f} deg against LiDAR and reference, which agree: `aslio calibrate` finds "
                    "its gyro_sensitivity",
                    kDegPerRad * d.size));
  }

  /// `corrected`: what the key would be.
  void report_rotation(const Difference& d, const std::string& subject, const std::string& key, const Pose& corrected) {
    const std::string axes = by_axis(d, kDegPerRad, 2, "deg");
    if (!d.open.empty()) {
      say(FindingKind::undetermined, subject, fmt::format("rotation about {}: too little turn to tell", d.open));
    }
    if (!d.known) return;
    const std::string size = fmt::format("{:.2f} +- {:.2f} deg", kDegPerRad * d.size, kDegPerRad * d.size_sigma);
    if (d.contradicts && sign_is_wrong_) {
      say(FindingKind::note, subject,
          fmt::format("rotation of {} off by {}: check again with the right signs", key, size));
    } else if (d.contradicts) {
      say(FindingKind::contradicts, subject, fmt::format("the rotation of {} is off by {} ({})", key, size, axes), key,
          pose_of(corrected));
    } else {
      say(FindingKind::agrees, subject, fmt::format("rotation of {} within {} ({})", key, size, axes));
    }
  }

  /// "late by 3.2 +- 0.1 ms".
  static std::string late_by(double late, double sigma) {
    return fmt::format("{} by {:.1f} +- {:.1f} ms", late < 0 ? "early" : "late", 1e3 * std::abs(late), 1e3 * sigma);
  }

  /// [Hz], infinite where there are no samples to count.
  double imu_rate() const {
    const auto& imu = m_.motion.imu;
    return imu.size() < 2 ? std::numeric_limits<double>::infinity()
                          : static_cast<double>(imu.size() - 1) / to_seconds(imu.back().t - imu.front().t);
  }

  void judge_clocks() {
    const auto& fit = m_.gyro_lidar;
    if (!fit.problem.empty()) return;
    const double d = fit.delay, sigma = std::hypot(fit.sigma_delay, kDelayFloor);
    const std::string value = late_by(-d, sigma);
    if (std::abs(d) < kDelayTolerated || std::abs(d) < 3 * sigma) {
      return say(FindingKind::agrees, "LiDAR and IMU clocks",
                 fmt::format("the LiDAR's times are {}; filters of an IMU look the same", value));
    }
    if (imu_rate() < kDelayRate) {
      return say(FindingKind::undetermined, "LiDAR and IMU clocks",
                 fmt::format("the LiDAR's times would be {}; an IMU of {:.1f} Hz cannot tell", value, imu_rate()));
    }
    if (name_stamp(d, sigma, value)) return;
    const bool reference_knows = m_.has_reference && m_.gyro_reference.problem.empty() && m_.gyro_reference.turns > 0;
    const double imu_off = reference_knows ? m_.gyro_reference.delay : 0;
    if (reference_knows && std::abs(imu_off) < kDelayTolerated && std::abs(d - imu_off) < kDelayTolerated) {
      return say(FindingKind::agrees, "LiDAR and IMU clocks",
                 fmt::format("the LiDAR's times are {} against the IMU's, and {} against the reference's", value,
                             late_by(imu_off - d, sigma)));
    }
    if (reference_knows && std::abs(imu_off) < kDelayTolerated) {
      return say(FindingKind::contradicts, "LiDAR and IMU clocks",
                 fmt::format("the LiDAR's times are {}; IMU and reference agree", value), "lidar_time_offset",
                 fmt::format("{:.4f}", sensor_.times.lidar_time_offset + d));
    }
    say(FindingKind::contradicts, "LiDAR and IMU clocks",
        fmt::format("the LiDAR's times are {} against the IMU's{}", value,
                    reference_knows ? ", the reference's as well" : "; which clock is right, they cannot tell"),
        "imu_time_offset", fmt::format("{:.4f}", sensor_.times.imu_time_offset - d));
  }

  /// A delay of a sweep, or of half of one, is no clock's: the stamp is of another moment of the sweep.
  bool name_stamp(double d, double sigma, const std::string& value) {
    const double period = m_.motion.sweep_period > 0 ? m_.motion.sweep_period : sensor_.model.sweep_period;
    const double within = std::max(3 * sigma, kStampTolerated);
    using io::LidarStamp;
    const LidarStamp now = sensor_.times.lidar_stamp;
    // Moments of the sweep, in sweeps after its start, that the files take the stamp for.
    const double taken = now == LidarStamp::end ? 1.0 : now == LidarStamp::middle ? 0.5 : 0.0;
    struct Named {
      double moment;
      const char* name;
    };
    for (const Named& is : {Named{0, "start"}, Named{0.5, "middle"}, Named{1, "end"}}) {
      if (is.moment == taken || std::abs(d + (is.moment - taken) * period) > within) continue;
      if (std::abs((is.moment - taken) * period) < 0.02) continue;
      say(FindingKind::contradicts, "LiDAR stamps",
          fmt::format("the LiDAR's times are {}: its stamps are those of the {} of a sweep of {:.0f} ms", value,
                      is.name, 1e3 * period),
          "lidar_stamp", is.name);
      return true;
    }
    return false;
  }

  void judge_rest() {
    const RestForce& rest = m_.rest;
    const bool still = rest.seconds > 0, fitted = !still && m_.force_lidar.problem.empty() && m_.force_lidar.pieces > 0;
    const double norm = fitted ? m_.force_lidar.gravity : rest.mean.norm();
    const std::string where =
        still ? fmt::format("at rest ({:.0f} s)", rest.seconds) : "as a mean, for it never rests,";
    const std::string text =
        fitted ? fmt::format("never at rest; {:.2f} +- {:.2f} m/s^2 of gravity remain without the motion of the LiDAR",
                             norm, m_.force_lidar.sigma_gravity)
               : fmt::format("{} is {:.3f} m/s^2, {}", where, norm, list_of(rest.mean, 3));
    if (norm < 0.5) {
      return say(FindingKind::contradicts, "specific force",
                 text + ": gravity has been taken out, or it is in another unit. No key adds it: use the raw data");
    }
    if (norm > 0.8 && norm < 1.2)
      return say(FindingKind::contradicts, "specific force", text + ": it is in g", "acc_unit", "g");
    const double allowed = still ? 0.5 : 2.0;
    if (std::abs(norm - kStandardGravity) > allowed) {
      return say(still ? FindingKind::contradicts : FindingKind::undetermined, "specific force",
                 text + ": it should be 9.81 m/s^2; look for a wrong unit or scale");
    }
    say(FindingKind::agrees, "specific force", text);
  }

  void judge_force_lidar() {
    const auto& fit = m_.force_lidar;
    if (!fit.problem.empty()) return say(FindingKind::undetermined, "LiDAR against accelerometer", fit.problem);
    force_covariance_ = fit.covariance + kLidarForceFloor * kLidarForceFloor * Mat3::Identity();
    force_shift_ = fit.lever - sensor_.model.T_imu_lidar.p;
    const Difference d = difference(force_shift_, force_covariance_, kShiftBound, kShiftTolerated);
    report_shift(d, "LiDAR against accelerometer", "T_imu_lidar", pose_of({sensor_.model.T_imu_lidar.R, fit.lever}));
  }

  void report_shift(const Difference& d, const std::string& subject, const std::string& key, const std::string& value) {
    if (!d.open.empty()) {
      say(FindingKind::undetermined, subject,
          fmt::format("lever arm along {}: too little turn to tell (sigma {:.0f} mm)", d.open,
                      1e3 * d.sigma.maxCoeff()));
    }
    if (!d.known) return;
    const std::string size = fmt::format("{:.0f} +- {:.0f} mm", 1e3 * d.size, 1e3 * d.size_sigma);
    const std::string axes = by_axis(d, 1e3, 0, "mm");
    if (d.contradicts && sign_is_wrong_) {
      say(FindingKind::note, subject, fmt::format("lever arm off by {}: check again with the right signs", size));
    } else if (d.contradicts) {
      say(FindingKind::contradicts, subject, fmt::format("the translation of {} is off by {} ({})", key, size, axes),
          key, value);
    } else {
      say(FindingKind::agrees, subject, fmt::format("translation of {} within {} ({})", key, size, axes));
    }
  }

  void judge_reference() {
    if (!m_.reference_has_rotation) return judge_point();
    const auto& gyro = m_.gyro_reference;
    if (!gyro.problem.empty()) {
      say(FindingKind::undetermined, "reference against gyro", gyro.problem);
    } else {
      judge_reference_frame();
    }
    judge_hand_eye();
  }

  /// A reference with positions only: where its point is, and its clock.
  void judge_point() {
    const auto& fit = m_.lidar_point;
    const std::string subject = "reference point against LiDAR";
    if (turned_) return say(FindingKind::undetermined, subject, "check again with the right rotation");
    if (!fit.problem.empty()) return say(FindingKind::undetermined, subject, fit.problem);
    const Mat3& R = sensor_.model.T_imu_lidar.R;
    const Vec3 point = sensor_.model.T_imu_lidar * fit.point;
    const Mat3 covariance = R * fit.covariance * R.transpose() + kPointFloor * kPointFloor * Mat3::Identity();
    const Difference d = difference(point - truth_->point, covariance, kShiftBound, kPointTolerated);
    report_shift(d, subject, "lever_arm", list_of(point, 3));
    const double sigma = std::hypot(fit.sigma_delay, kDelayFloor), off = fit.delay;
    const std::string text = fmt::format("the reference's times are {} against the LiDAR's", late_by(off, sigma));
    const bool wrong = std::abs(off) > kPointDelayTolerated && std::abs(off) > 4 * sigma;
    say(wrong ? FindingKind::contradicts : FindingKind::agrees, "reference and LiDAR clocks", text,
        wrong ? "reference.time_offset" : "", wrong ? fmt::format("{:.4f}", truth_->spec.time_offset - off) : "");
  }

  void judge_reference_frame() {
    const auto& gyro = m_.gyro_reference;
    const Mat3 R = gyro.R_A_B.transpose();  // R_I_R
    const Mat3 covariance = R * gyro.covariance * R.transpose() + gyro_axes() * gyro_axes() * Mat3::Identity();
    const Difference turn = difference(log_so3(R), covariance, kTurnBound, kTurnTolerated);
    const Pose declared = io::pose_in_imu(truth_->spec, sensor_.all_transforms());
    if (!turn.contradicts || !axes_of_gyro_off_) {
      report_rotation(turn, "reference against gyro", "T_imu_reference", Pose{R, Vec3::Zero()} * declared);
      reference_turned_ = turn.contradicts;
    }
    const double d = gyro.delay, sigma = std::hypot(gyro.sigma_delay, kDelayFloor);
    const std::string value = late_by(-d, sigma);
    const bool lidar_agrees_with_imu = m_.gyro_lidar.problem.empty() && std::abs(m_.gyro_lidar.delay) < kDelayTolerated;
    if (std::abs(d) < kDelayTolerated || std::abs(d) < 3 * sigma) {
      say(FindingKind::agrees, "reference and IMU clocks", fmt::format("the reference's times are {}", value));
    } else if (lidar_agrees_with_imu || !m_.gyro_lidar.problem.empty()) {
      say(FindingKind::contradicts, "reference and IMU clocks",
          fmt::format("the reference's times are {} against the IMU's", value), "reference.time_offset",
          fmt::format("{:.4f}", truth_->spec.time_offset + d));
    } else {
      say(FindingKind::note, "reference and IMU clocks",
          fmt::format("the reference's times are {} against the IMU's, and so are the LiDAR's", value));
    }
    judge_reference_lever(declared);
  }

  void judge_reference_lever(const Pose& declared) {
    const auto& force = m_.force_reference;
    if (!force.problem.empty()) return say(FindingKind::undetermined, "reference against accelerometer", force.problem);
    const Mat3 covariance = force.covariance + kForceFloor * kForceFloor * Mat3::Identity();
    const Difference d = difference(force.lever, covariance, kShiftBound, kShiftTolerated);
    report_shift(d, "reference against accelerometer", "T_imu_reference",
                 pose_of(Pose{Mat3::Identity(), force.lever} * declared));
    reference_shifted_ = d.contradicts;
    if (m_.rest.tilt && *m_.rest.tilt > 150 * kRadPerDeg) {
      say(FindingKind::note, "specific force", "it points down the z axis of the reference: z of its world is down");
    }
  }

  void judge_hand_eye() {
    const auto& fit = m_.lidar_reference;
    if (!fit.problem.empty()) return say(FindingKind::undetermined, "LiDAR against reference", fit.problem);
    Mat6 floor = Mat6::Zero();
    floor.diagonal() << Vec3::Constant(kPoseAxes * kPoseAxes), Vec3::Constant(kPoseFloor * kPoseFloor);
    pose_covariance_ = fit.covariance + floor;
    pose_off_ << log_so3(fit.T_B_A.R * sensor_.model.T_imu_lidar.R.transpose()),
        fit.T_B_A.p - sensor_.model.T_imu_lidar.p;
    const Difference turn =
        difference(pose_off_.head<3>(), pose_covariance_.topLeftCorner<3, 3>(), kTurnBound, kTurnTolerated);
    const Difference shift =
        difference(pose_off_.tail<3>(), pose_covariance_.bottomRightCorner<3, 3>(), kShiftBound, kShiftTolerated);
    const char* key = reference_turned_ || reference_shifted_ ? "T_imu_reference or T_imu_lidar" : "T_imu_lidar";
    report_rotation(turn, "LiDAR against reference", key, fit.T_B_A);
    report_shift(shift, "LiDAR against reference", key, pose_of(fit.T_B_A));
    say(FindingKind::note, "LiDAR against reference",
        fmt::format("displacements over 1 s differ by {:.0f} mm with T_imu_lidar of the files, by {:.0f} mm with the "
                    "measured one ({} of them)",
                    1e3 * fit.rms_expected, 1e3 * fit.rms, fit.pairs));
  }

  /// The extrinsic by all that tells of it, weighed by covariances, as a difference to that of the files.
  void fuse() {
    if (!m_.gyro_lidar.problem.empty() || turned_) return;
    Mat6 information = Mat6::Zero();
    Vec6 sum = Vec6::Zero();
    const Mat3 by_gyro = gyro_covariance_.inverse();
    information.topLeftCorner<3, 3>() += by_gyro;
    sum.head<3>() += by_gyro * gyro_turn_;
    if (m_.force_lidar.problem.empty()) {
      const Mat3 by_force = force_covariance_.inverse();
      information.bottomRightCorner<3, 3>() += by_force;
      sum.tail<3>() += by_force * force_shift_;
    }
    const bool by_reference = m_.has_reference && m_.reference_has_rotation && m_.lidar_reference.problem.empty();
    if (by_reference && !reference_turned_ && !reference_shifted_) {
      const Mat6 by_pose = pose_covariance_.inverse();
      information += by_pose;
      sum += by_pose * pose_off_;
    }
    constexpr double kAnything = 1.0;  // 1/m^2: a metre either way of what nothing binds
    information.bottomRightCorner<3, 3>() += kAnything * Mat3::Identity();
    MeasuredExtrinsic extrinsic;
    extrinsic.covariance = information.inverse();
    const Vec6 off = extrinsic.covariance * sum;
    const Pose& declared = sensor_.model.T_imu_lidar;
    extrinsic.T_imu_lidar = {orthonormalised(exp_so3(off.head<3>()) * declared.R), declared.p + off.tail<3>()};
    check_.extrinsic = extrinsic;
  }

  /// Where one of the comparisons contradicts the extrinsic, the value to set is that by all of them.
  void name_extrinsic() {
    if (!check_.extrinsic) return;
    for (Finding& finding : check_.findings) {
      if (finding.key == "T_imu_lidar") finding.value = pose_of(check_.extrinsic->T_imu_lidar);
    }
  }

  FrameCheck& check_;
  const FrameMeasurement& m_;
  const io::SensorConfig& sensor_;
  const Truth* truth_;
  Vec3 gyro_turn_ = Vec3::Zero(), force_shift_ = Vec3::Zero();
  Mat3 gyro_covariance_ = Mat3::Identity(), force_covariance_ = Mat3::Identity();
  Vec6 pose_off_ = Vec6::Zero();
  Mat6 pose_covariance_ = Mat6::Identity();
  bool turned_ = false;  ///< the LiDAR, by half a turn
  bool sign_is_wrong_ = false, axes_of_gyro_off_ = false, reference_turned_ = false, reference_shifted_ = false;
};

}  // namespace

bool FrameCheck::contradicts() const {
  for (const Finding& finding : findings) {
    if (finding.kind == FindingKind::contradicts) return true;
  }
  return false;
}

FrameCheck judge_frames(FrameMeasurement measurement, const io::SensorConfig& sensor, const Truth* truth,
                        const std::vector<PublishedExtrinsic>& published) {
  FrameCheck check;
  check.measurement = std::move(measurement);
  Judge(check, sensor, truth).run();
  compare_published(published, check);
  return check;
}

}  // namespace aslio::experiment
