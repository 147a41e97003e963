#pragma once
/// Whether the frames, signs and clocks of a recording are as its files say: the content of `aslio inspect --check`.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/evaluation/force_fit.hpp"
#include "aslio/evaluation/hand_eye.hpp"
#include "aslio/evaluation/point_fit.hpp"
#include "aslio/evaluation/rotation_fit.hpp"
#include "aslio/experiment/lidar_motion.hpp"
#include "aslio/experiment/published_extrinsic.hpp"
#include "aslio/experiment/truth.hpp"

namespace aslio::experiment {

/// Specific force while the IMU is at rest.
struct RestForce {
  double seconds = 0;          ///< at rest; 0: never, and the mean is of all samples
  Vec3 mean = Vec3::Zero();    ///< [m/s^2], in the IMU frame
  std::optional<double> tilt;  ///< angle to the reference's z axis [rad]
};

/// All that is measured, in the frames of the files. I: IMU, L: LiDAR, R: the IMU frame as the reference gives it.
struct FrameMeasurement {
  LidarMotion motion;
  bool has_reference = false;
  bool reference_has_rotation = false;
  evaluation::RotationFit gyro_lidar;      ///< A = L, B = I
  evaluation::RotationFit gyro_reference;  ///< A = R, B = I
  evaluation::HandEye lidar_reference;     ///< A = L, B = R
  evaluation::PointFit lidar_point;        ///< A = L, of a reference with positions only
  evaluation::ForceFit force_lidar;        ///< A = L
  evaluation::ForceFit force_reference;    ///< A = R
  RestForce rest;
};

enum class FindingKind : std::uint8_t {
  agrees,        ///< with the files
  contradicts,   ///< the files are wrong beyond doubt
  undetermined,  ///< the data cannot tell
  note           ///< worth knowing, and no contradiction
};

struct Finding {
  FindingKind kind = FindingKind::note;
  std::string subject;  ///< "gyro signs"
  std::string text;     ///< a sentence with value and standard deviation
  std::string key;      ///< to set, where the files are wrong: "T_imu_lidar", "imu_time_offset", ..
  std::string value;    ///< to set it to, YAML
};

/// T_imu_lidar as the data have it.
struct MeasuredExtrinsic {
  Pose T_imu_lidar;
  Mat6 covariance = Mat6::Identity();  ///< of (theta, p) in the axes of I [rad^2, m^2]
};

/// A published extrinsic beside the measured one.
struct ExtrinsicComparison {
  std::string source;
  double rotation = 0, rotation_sigmas = 0;  ///< difference [rad], and in standard deviations of the measured one
  double shift = 0, shift_sigmas = 0;        ///< [m]
  bool fits = false;                         ///< by no more than 3.5 standard deviations, or what is tolerated
};

struct FrameCheck {
  FrameMeasurement measurement;
  std::vector<Finding> findings;
  std::optional<MeasuredExtrinsic> extrinsic;  ///< nothing where no rotation was found
  std::vector<ExtrinsicComparison> published;
  std::string published_verdict;  ///< which of them fits, or why the data cannot tell; empty without any

  bool contradicts() const;
};

struct FrameCheckOptions {
  LidarMotionOptions motion;
  /// In place of those of `motion`, where with them the turns of the LiDAR do not follow a gyro that turns slowly, as
  /// on a car: longer windows then see more, and the motion within them is uniform.
  std::optional<std::vector<std::string>> slow_overrides;
  std::optional<io::ReferenceSpec> reference;
  std::vector<PublishedExtrinsic> published;
};

/// Measures and judges. Throws ConfigError and DataError as read_lidar_motion() and load_truth() do, and DataError
/// where no sweep could be registered.
FrameCheck check_frames(const FrameCheckOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor);

/// The judgement alone (eq. FRM-6). `truth`: null without a reference.
FrameCheck judge_frames(FrameMeasurement measurement, const io::SensorConfig& sensor, const Truth* truth,
                        const std::vector<PublishedExtrinsic>& published);

/// Aligned text of many lines, for people.
std::string render(const FrameCheck& check);
/// The same for machines: findings, fits with their deviations, published extrinsics.
std::string to_json(const FrameCheck& check);

}  // namespace aslio::experiment
