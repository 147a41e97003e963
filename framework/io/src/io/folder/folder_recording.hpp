#pragma once
/// Recordings that are folders of files. Each kind of folder tells its scans and IMU samples in this form, so that one
/// reader yields them as if they were the messages of a bag, and one set of rules judges both.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "aslio/core/types.hpp"
#include "aslio/io/rosbag/messages.hpp"

namespace aslio::io {

/// Points as they lie in a file: numbers of fixed columns, little-endian, point after point.
struct PointTable {
  std::vector<rosbag::PointField> columns;
  std::uint32_t point_step = 0;     ///< bytes of a point
  std::vector<std::uint8_t> bytes;  ///< of whole points
  std::string damage;               ///< why there are fewer points than there should be; empty: there are not
};

struct ScanFile {
  TimeNs stamp = 0;  ///< what the times of its points count from
  std::filesystem::path path;
};

/// The scans of one LiDAR, in any order.
struct ScanTrack {
  std::string topic;
  std::vector<ScanFile> scans;
  /// The points of scans[i]. Throws DataError that names the file.
  std::function<void(std::size_t i, PointTable& table)> read;
};

/// The samples of one IMU, in any order, in the units of their files.
struct ImuTrack {
  std::string topic;
  std::vector<ImuSample> samples;
};

struct FolderRecording {
  std::string kind;  ///< for people: "KITTI raw drive", ..
  std::filesystem::path folder;
  std::vector<ImuTrack> imus;
  std::vector<ScanTrack> lidars;
  std::vector<std::string> verdicts, warnings;
  std::string without_imu;  ///< what to do where there is no IMU
};

}  // namespace aslio::io
