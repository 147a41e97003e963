#pragma once
/// What stands in an input, and whether it can be used: the content of `aslio inspect`.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/io/source.hpp"

namespace aslio::io {

enum class TopicRole : std::uint8_t { lidar, imu, other };

struct TopicReport {
  std::string topic, type, md5;
  TopicRole role = TopicRole::other;
  std::uint64_t messages = 0;
  double rate = 0;                    ///< [Hz], over the whole extent
  double median_period = 0;           ///< [s]
  double largest_gap = 0;             ///< [s]
  std::uint64_t backward = 0;         ///< stamps before their predecessor
  std::uint64_t repeated = 0;         ///< stamps equal to their predecessor
  double points_per_message = 0;      ///< LiDAR: those kept
  std::uint64_t empty = 0;            ///< LiDAR: messages without a point that is kept
  std::uint64_t malformed = 0;        ///< messages that cannot be decoded
  int lines = 0;                      ///< LiDAR: highest line of a point, and one
  std::string acc_unit, gyro_unit;    ///< IMU: as found, in the words of a sensor file
  std::string fields;                 ///< PointCloud2: the field table
  std::vector<std::string> verdicts;  ///< units, point times
  std::string problem;                ///< why the topic cannot be used; empty: it can
};

struct InputReport {
  std::string name;  ///< path, or several with commas between them
  std::string kind;  ///< "ROS1 bag", "KITTI raw drive", ..
  std::uint64_t bytes = 0;
  TimeNs begin = 0, end = 0;  ///< record time of a bag, data time of a folder
  InputStatus status = InputStatus::complete;
  std::vector<TopicReport> topics;  ///< by name
  std::vector<std::string> warnings;
  bool usable = false;
  std::string reason;  ///< why not

  double duration() const { return to_seconds(end - begin); }
};

/// Reads the whole input once. With a sensor file, judges as a run with it would; without, by what is found. Throws
/// DataError when it is no known kind of input, or damaged.
InputReport inspect(const std::filesystem::path& path, const SensorConfig& sensor = {});
/// Several recordings of messages as one, as open_source() takes them. Pre: one at least.
InputReport inspect(const std::vector<std::filesystem::path>& inputs, const SensorConfig& sensor = {});

/// Aligned text of many lines, for people.
std::string render(const InputReport& report);

/// A sensor file that fits what was found: topics, units, sweep period, scan lines. What data cannot tell (extrinsic,
/// noise) stands there with a remark. Throws DataError where there is not one LiDAR and one IMU topic that can be used.
std::string draft_sensor(const InputReport& report);

}  // namespace aslio::io
