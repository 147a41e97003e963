#pragma once
/// Small recordings made to measure.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "aslio/io/inspect.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "aslio/io/source.hpp"
#include "temporary_folder.hpp"

namespace aslio::io::test {

/// A folder of its own, removed at the end; in memory where there is a place for it, since these tests write thousands
/// of small files.
class TemporaryFolder : public aslio::test::TemporaryFolder {
 public:
  TemporaryFolder();
};

inline constexpr TimeNs kStart = 1'600'000'000 * kSecond;

/// A recording of `seconds`: IMU at 100 Hz, LiDAR at 10 Hz with `points` points; each part may be changed.
struct Recording {
  double seconds = 2;
  int points = 20;
  Vec3 acc{0, 0, 9.8}, gyro{0.01, 0, 0};
  std::string lidar_topic = "/livox/lidar", imu_topic = "/livox/imu";
  rosbag::MessageType lidar_type = rosbag::kLivoxCustomMsg;
  rosbag::MessageType imu_type = rosbag::kImu;
  rosbag::WriterOptions options{rosbag::Compression::none, 4096, true};
  TimeNs timebase_shift = 0;
  /// Replaces the LiDAR message of sweep `k`; null: a Livox message.
  std::function<std::vector<std::uint8_t>(int k, TimeNs stamp)> lidar;
  /// Replaces the angular rate of IMU sample `i`; null: `gyro`.
  std::function<Vec3(int i)> turn;
  /// Replaces the stamp of IMU sample `i`, but not the time at which it is recorded; null: that time.
  std::function<TimeNs(int i, TimeNs stamp)> imu_stamp;
  /// Replaces the time at which a message is recorded; null: its stamp.
  std::function<TimeNs(TimeNs stamp)> recorded;

  void write(const std::filesystem::path& path) const;
};

std::vector<std::uint8_t> livox_message(TimeNs stamp, TimeNs timebase, int points);

struct Counts {
  std::size_t packets = 0, points = 0, imu = 0, dropped = 0;
};
Counts drain(MeasurementSource& source);

std::vector<std::uint8_t> read_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

/// Text of the DataError thrown by `action`; empty when it does not throw one.
std::string data_error(const std::function<void()>& action);

bool contains(const std::vector<std::string>& texts, const std::string& part);
bool contains(const std::string& text, const std::string& part);

}  // namespace aslio::io::test
