#pragma once
/// Where measurements come from: bags and folders, pulled in the order of recording. Data time is the only clock.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/core/sensor.hpp"
#include "aslio/io/time_unit.hpp"
#include "aslio/io/transforms.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::io {

enum class AccUnit : std::uint8_t { automatic, g, mps2 };
enum class GyroUnit : std::uint8_t { automatic, rad_s, deg_s };

/// What the times of points count from; automatic: judged by the first clouds.
enum class PointTime : std::uint8_t { automatic, start, end, absolute, none };
/// What the header stamp of a LiDAR message is of; automatic: what the point times count from.
enum class LidarStamp : std::uint8_t { automatic, start, middle, end };
/// Which time of a message counts.
enum class StampKind : std::uint8_t { header, received };

/// How the times of a recording of messages are read.
struct InputTimes {
  PointTime point_time = PointTime::automatic;
  LidarStamp lidar_stamp = LidarStamp::automatic;
  TimeUnit point_time_unit = TimeUnit::automatic;
  std::string point_time_field;                       ///< of a PointCloud2; empty: the one of a known name
  double lidar_time_offset = 0, imu_time_offset = 0;  ///< added to all times of the sensor [s]
  StampKind stamps = StampKind::header;
  bool deskewed = false;                     ///< motion within a sweep has been taken out already
  static constexpr double kMaxOffset = 4e9;  ///< [s]: an uptime against an epoch

  static void describe(config::Binder& b, InputTimes& times);
};

/// A sensor file (`schema: aslio/sensor/1`). Directions stand in the key names: T_imu_lidar maps p_L to p_I.
struct SensorConfig {
  static constexpr double kMaxSensitivity = 0.2, kMaxDelay = 1.0;  ///< larger entries, and delays [s], are mistakes
  std::string lidar_topic, imu_topic;
  std::string
      scan_columns;  ///< of a folder's .bin files: `x y z intensity time ring:u16`; float32 where nothing is said
  std::string imu_columns;  ///< of a folder's table of an IMU that has no line of names: `timestamp wx wy wz ax ay az`
  std::string lidar_metadata;     ///< file of an Ouster's metadata; empty: in the recording, or beside it by its name
  std::string lidar_calibration;  ///< file of a Hesai's own angles; empty: those of the manual
  std::string lidar_address;      ///< of the sensor to take from a capture of several; empty: the only one
  AccUnit acc_unit = AccUnit::automatic;
  GyroUnit gyro_unit = GyroUnit::automatic;
  bool livox_tag_filter = true;     ///< keep (tag & 0x30) in {0x00, 0x10} (first or strongest return)
  bool require_point_times = true;  ///< refuse clouds whose per-point time cannot be known
  int lidar_id = -1;        ///< the only one that is taken from a topic of several Livox sensors; -1: all are one
  std::string lidar_frame;  ///< the same of PointCloud2, by frame_id; empty: all are one
  InputTimes times;
  SensorModel model;
  // What is known of the IMU beforehand (docs/equations.md MOT-11): taken out of every sample that is read.
  Mat3 gyro_sensitivity = Mat3::Zero();                           ///< S: the gyro measures (I + S) w and a bias
  std::array<double, 3> gyro_signs{1, 1, 1}, acc_signs{1, 1, 1};  ///< -1: the axis points the other way
  double imu_delay = 0;                    ///< a sample tells of the motion this long before its stamp [s]
  std::vector<NamedTransform> transforms;  ///< between further frames, for a reference in one of them
  bool from_file = false;  ///< a sensor file was read: its extrinsic is meant, also where it is the identity
  bool extrinsic_placeholder = false;  ///< T_imu_lidar stands for a value that nobody has measured yet
  std::string placeholder_warning;     ///< says so, with file and line; load_sensor() fills it; empty: none

  /// `transforms`, and T_imu_lidar between the frames `imu` and `lidar`.
  std::vector<NamedTransform> all_transforms() const;

  static void describe(config::Binder& b, SensorConfig& sensor);
};

/// How complete the input was; known once the end has been reached.
enum class InputStatus : std::uint8_t { complete, truncated };

/// Facts found while reading, stated to the user: verdicts on units and time fields, repaired damage.
struct SourceNotes {
  std::vector<std::string> verdicts;  ///< e.g. "imu acceleration: g (static norm 0.998), multiplied by 9.80665"
  std::vector<std::string> warnings;
  /// Messages so far that could not be decoded and were skipped; a warning tells what was wrong with the first. Grows
  /// while the source is read.
  std::uint64_t malformed_lidar = 0, malformed_imu = 0;
};

class MeasurementSource {
 public:
  virtual ~MeasurementSource() = default;
  /// Next measurement in recording order, or nothing at the end. Throws DataError for damage that cannot be skipped.
  virtual std::optional<Measurement> next() = 0;
  /// Adds to the notes what only all that was read together can tell. The end of the data does so by itself; whoever
  /// stops before it calls this.
  virtual void conclude() {}
  virtual InputStatus status() const = 0;
  virtual const SourceNotes& notes() const = 0;
  /// Data-time extent for progress; nullopt when not known before reading.
  virtual std::optional<TimeNs> begin_time() const = 0;
  virtual std::optional<TimeNs> end_time() const = 0;
};

/// Data-time section [begin + start, begin + start + duration) in seconds.
struct Section {
  double start = 0;
  std::optional<double> duration;
};

/// Opens a recording of messages (a bag, MCAP file or rosbag2 database, a folder or pattern of parts) or a folder of
/// files (a KITTI raw drive, scans with a table of an IMU), by what it is. Checks topics and types at once; throws
/// DataError that names the file, what was found and the remedy; a pipe or device is refused without being opened.
std::unique_ptr<MeasurementSource> open_source(const std::filesystem::path& path, const SensorConfig& sensor,
                                               const Section& section = {});

/// Several recordings of messages as one: parts of a run, a file per sensor.
std::unique_ptr<MeasurementSource> open_source(const std::vector<std::filesystem::path>& inputs,
                                               const SensorConfig& sensor, const Section& section = {});

/// SHA-256 of a file, or of the names and contents of a folder's data files, or of those that a pattern matches; hex.
std::string input_digest(const std::filesystem::path& path);
/// Of several inputs that are read as one; that of a single one is its own.
std::string input_digest(const std::vector<std::filesystem::path>& inputs);
/// An input that exists, or a pattern with `*`, `?` or `[`.
bool is_input(const std::filesystem::path& path);

}  // namespace aslio::io
