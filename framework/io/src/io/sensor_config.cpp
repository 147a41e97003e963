#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io {
namespace {

/// Calibration files carry six digits or more; what deviates further was mistyped.
constexpr double kOrthonormalTolerance = 1e-4;

/// A 3x3 matrix from nine numbers, row by row; zero unless there are nine.
Mat3 matrix_of(const std::vector<double>& rows) {
  Mat3 M = Mat3::Zero();
  for (std::size_t i = 0; i < 9 && rows.size() == 9; ++i) {
    M(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = rows[i];
  }
  return M;
}

std::vector<double> rows_of(const Mat3& M) {
  std::vector<double> rows;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows.push_back(M(row, column));
  }
  return rows;
}

struct PoseBlock {
  std::vector<double> translation, rotation;
  bool placeholder;

  PoseBlock(const Pose& T, bool not_measured)
      : translation{T.p.x(), T.p.y(), T.p.z()}, rotation(rows_of(T.R)), placeholder(not_measured) {}

  static void describe(config::Binder& b, PoseBlock& block) {
    b.reals("translation", block.translation, 3, "m", {.min = -100.0, .max = 100.0},
            "origin of the LiDAR in the IMU frame");
    b.reals("rotation", block.rotation, 9, "1", {.min = -1.001, .max = 1.001},
            "rotation from the LiDAR to the IMU frame, row by row");
    b.flag("placeholder", block.placeholder,
           "nobody has measured this pose yet: whatever uses it warns; delete the line once the pose is right");
    const Mat3 R = matrix_of(block.rotation);
    const double deviation = (R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff();
    b.require(deviation < kOrthonormalTolerance, "rotation",
              fmt::format("is not orthonormal: R^T R deviates from identity by {:.3g} (at most {:.0e})", deviation,
                          kOrthonormalTolerance));
    const double determinant = R.col(0).cross(R.col(1)).dot(R.col(2));
    b.require(deviation >= kOrthonormalTolerance || determinant > 0, "rotation",
              "has determinant -1: it mirrors; a row or a column has the wrong sign");
  }
};

/// Three numbers, each 1 or -1.
void describe_signs(config::Binder& b, const std::string& key, std::array<double, 3>& signs, const std::string& text) {
  std::vector<double> values(signs.begin(), signs.end());
  b.reals(key, values, 3, "1", {.min = -1.0, .max = 1.0}, text);
  const bool whole = std::all_of(values.begin(), values.end(), [](double v) { return std::abs(v) == 1; });
  b.require(whole, key, "must be of 1 and -1 alone");
  if (whole && values.size() == signs.size()) std::copy(values.begin(), values.end(), signs.begin());
}

}  // namespace

void InputTimes::describe(config::Binder& b, InputTimes& times) {
  b.choice(
      "lidar_stamp", times.lidar_stamp,
      {{"auto", LidarStamp::automatic},
       {"start", LidarStamp::start},
       {"middle", LidarStamp::middle},
       {"end", LidarStamp::end}},
      "moment of the sweep that the header stamp of a LiDAR message names; auto: the one that point times count from");
  b.choice("point_time", times.point_time,
           {{"auto", PointTime::automatic},
            {"start", PointTime::start},
            {"end", PointTime::end},
            {"absolute", PointTime::absolute},
            {"none", PointTime::none}},
           "what the times of points count from; auto: by the first clouds; none: all points take the header stamp");
  b.choice("point_time_unit", times.point_time_unit,
           {{"auto", TimeUnit::automatic},
            {"s", TimeUnit::s},
            {"ms", TimeUnit::ms},
            {"us", TimeUnit::us},
            {"ns", TimeUnit::ns}},
           "unit of the times of points; auto: the one in which they span a sweep");
  b.text("point_time_field", times.point_time_field,
         "field of a PointCloud2 with the time of a point; empty: t, time, time_stamp, timestamp, timestamps or "
         "offset_time");
  b.real("lidar_time_offset", times.lidar_time_offset, "s", {.min = -kMaxOffset, .max = kMaxOffset},
         "is added to all times of the LiDAR");
  b.real("imu_time_offset", times.imu_time_offset, "s", {.min = -kMaxOffset, .max = kMaxOffset},
         "is added to all times of the IMU");
  b.choice("stamps", times.stamps, {{"header", StampKind::header}, {"received", StampKind::received}},
           "time of a message: that of its header, or that of its recording (a LiDAR message is received at the end of "
           "its sweep)");
  b.flag("deskewed", times.deskewed,
         "the motion within a sweep has been taken out: all its points are of the header stamp");
}

std::vector<NamedTransform> SensorConfig::all_transforms() const {
  std::vector<NamedTransform> all = transforms;
  NamedTransform mount{"imu", "lidar", {}};
  const Pose& T = model.T_imu_lidar;
  mount.T.translation = {T.p.x(), T.p.y(), T.p.z()};
  mount.T.rotation = rows_of(T.R);
  all.push_back(std::move(mount));
  return all;
}

namespace {

/// How a recording is read.
void describe_recording(config::Binder& b, SensorConfig& sensor) {
  b.text("lidar_topic", sensor.lidar_topic, "LiDAR topic of a bag; empty: the only one of a known type");
  b.text("imu_topic", sensor.imu_topic, "IMU topic of a bag; empty: the only one");
  b.text("scan_columns", sensor.scan_columns,
         "columns of the .bin scans of a folder, like `x y z intensity time ring:u16`; float32 where no type is named");
  b.text("imu_columns", sensor.imu_columns,
         "columns of a folder's IMU table that does not name them, like `timestamp wx wy wz ax ay az`");
  b.text(
      "lidar_metadata", sensor.lidar_metadata,
      "file of an Ouster sensor's metadata (JSON), for raw packets; empty: in the recording, or beside it by its name");
  b.text(
      "lidar_calibration", sensor.lidar_calibration,
      "file of a Hesai sensor's own angles (lines `channel,elevation,azimuth`, deg), for raw packets; empty: those of "
      "the manual");
  b.text("lidar_address", sensor.lidar_address,
         "IP address of the sensor to take from a capture of several (pcap); empty: the only one");
  b.choice("acc_unit", sensor.acc_unit, {{"auto", AccUnit::automatic}, {"g", AccUnit::g}, {"mps2", AccUnit::mps2}},
           "unit of the acceleration; auto: by its norm in the first second");
  b.choice("gyro_unit", sensor.gyro_unit,
           {{"auto", GyroUnit::automatic}, {"rad_s", GyroUnit::rad_s}, {"deg_s", GyroUnit::deg_s}},
           "unit of the angular rate; auto: rad/s unless too fast for any gyroscope");
  b.flag("livox_tag_filter", sensor.livox_tag_filter, "drop Livox returns whose tag marks them as noise");
  b.flag(
      "require_point_times", sensor.require_point_times,
      "refuse clouds whose point times cannot be known; false: all points take the header stamp, without de-skewing");

  std::int64_t id = sensor.lidar_id;
  b.integer("lidar_id", id, "1", {.min = -1, .max = 255},
            "Livox sensor to take from a topic that carries several; -1: the topic carries one");
  sensor.lidar_id = static_cast<int>(id);
  b.text("lidar_frame", sensor.lidar_frame,
         "frame_id of the PointCloud2 to take from a topic that carries several; empty: the topic carries one");
  InputTimes::describe(b, sensor.times);
  describe_signs(b, "gyro_signs", sensor.gyro_signs, "sign of each gyroscope axis; -1 where a driver turns it round");
  describe_signs(
      b, "acc_signs", sensor.acc_signs,
      "sign of each accelerometer axis; all -1 for a driver that reports gravity in place of specific force");
}

void describe_extrinsic(config::Binder& b, SensorConfig& sensor) {
  SensorModel& model = sensor.model;
  PoseBlock extrinsic(model.T_imu_lidar, sensor.extrinsic_placeholder);
  b.group("T_imu_lidar", extrinsic, "pose of the LiDAR in the IMU frame: p_I = T_imu_lidar p_L");
  sensor.extrinsic_placeholder = extrinsic.placeholder;
  if (extrinsic.translation.size() == 3 && extrinsic.rotation.size() == 9) {
    // Digits cut by hand are made a rotation again; full precision is kept bit for bit, so that a dump reads back
    // equal.
    const Mat3 R = matrix_of(extrinsic.rotation);
    const bool exact = (R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-12;
    model.T_imu_lidar.p = Vec3(extrinsic.translation[0], extrinsic.translation[1], extrinsic.translation[2]);
    model.T_imu_lidar.R = exact ? R : orthonormalised(R);
  }
}

/// Ranges and noise.
void describe_model(config::Binder& b, SensorModel& model) {
  std::int64_t lines = model.scan_lines;
  b.integer("scan_lines", lines, "1", {.min = 1, .max = 256}, "scan lines; Livox points of a higher line are dropped");
  model.scan_lines = static_cast<int>(lines);
  b.real("min_range", model.min_range, "m", {.min = 0.0, .max = 100.0}, "returns nearer are the carrier or noise");
  b.real("max_range", model.max_range, "m", {.above = 0.0, .max = 1000.0}, "returns farther are not used");
  b.require(model.max_range > model.min_range, "max_range", "must be above min_range");
  b.real("sweep_period", model.sweep_period, "s", {.min = 0.001, .max = 2.0}, "time between LiDAR messages");
  b.real("range_sigma", model.range_sigma, "m", {.above = 0.0, .max = 1.0}, "standard deviation of a measured range");
  b.real("range_sigma_growth", model.range_sigma_growth, "m/m", {.min = 0.0, .max = 0.1},
         "what each metre of range adds to range_sigma");
  b.real("gyro_range", model.gyro_range, "rad/s", {.min = 0.0, .max = 1000.0},
         "largest rate that the gyroscope reports on an axis; 0: unknown");
  b.real("acc_range", model.acc_range, "m/s^2", {.min = 0.0, .max = 10000.0},
         "largest specific force that the accelerometer reports on an axis; 0: unknown");
  b.real("gyro_noise", model.gyro_noise, "rad/s/sqrt(Hz)", {.above = 0.0, .max = 10.0}, "angular rate noise density");
  b.real("acc_noise", model.acc_noise, "m/s^2/sqrt(Hz)", {.above = 0.0, .max = 100.0}, "acceleration noise density");
  b.real("gyro_bias_walk", model.gyro_bias_walk, "rad/s^2/sqrt(Hz)", {.above = 0.0, .max = 10.0},
         "random walk density of the gyroscope bias");
  b.real("acc_bias_walk", model.acc_bias_walk, "m/s^3/sqrt(Hz)", {.above = 0.0, .max = 100.0},
         "random walk density of the accelerometer bias");
}

}  // namespace

void SensorConfig::describe(config::Binder& b, SensorConfig& sensor) {
  sensor.from_file = true;
  describe_recording(b, sensor);
  describe_extrinsic(b, sensor);
  b.groups("transforms", sensor.transforms,
           "transforms between further frames, for a reference in one of them; `imu` and `lidar` are those of "
           "T_imu_lidar, `reference` is the frame of a reference that names none");
  std::vector<double> sensitivity = rows_of(sensor.gyro_sensitivity);
  b.reals("gyro_sensitivity", sensitivity, 9, "1", {.min = -kMaxSensitivity, .max = kMaxSensitivity},
          "S, known beforehand, row by row: the gyro measures (I + S) w and a bias; taken out of what is read "
          "(`aslio calibrate` tells it from runs)");
  sensor.gyro_sensitivity = matrix_of(sensitivity);
  b.real("imu_delay", sensor.imu_delay, "s", {.min = -kMaxDelay, .max = kMaxDelay},
         "known beforehand: an IMU sample tells of the motion this long before its stamp; taken out of the stamps");
  describe_model(b, sensor.model);
}

}  // namespace aslio::io
