#pragma once
/// Runs `aslio` over altered recordings, as a user would: a bag, a sensor file, a pipeline file, an exit code.

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "cli/child.hpp"
#include "faults/injector.hpp"

namespace aslio::test::faults {

/// A recording with what is known of it.
struct Walk {
  Measurements data;
  std::vector<StampedPose> truth;  ///< T_W_I
  SensorModel sensor;
  TimeNs begin() const { return stamp_of(data.front()); }
};

/// The simulated walk through a corridor and a room from which all faults are made: 12 s (the first one at rest), a
/// LiDAR that sees all round with about 5000 points per sweep, an IMU of 200 Hz. Made once per build folder.
const Walk& clean_walk();

/// How a recording becomes a bag: a PointCloud2 with x, y, z, intensity, ring and `t` (int32 ns after the stamp), and
/// IMU messages in rad/s and m/s^2.
struct BagForm {
  io::rosbag::WriterOptions options{io::rosbag::Compression::none, 768 * 1024, true};
  std::string lidar_topic = "/points", imu_topic = "/imu";
  io::rosbag::MessageType lidar_type = io::rosbag::kPointCloud2, imu_type = io::rosbag::kImu;
  bool point_times = true;  ///< false: no field of that name
  double time_unit = 1;     ///< the field counts in so many ns
  double gyro_factor = 1, acc_factor = 1;
  /// Alters the fields, sizes and bytes of message `index`.
  std::function<void(io::rosbag::CloudLayout&, std::vector<std::uint8_t>&, std::size_t index)> edit = {};
};
void write_bag(const std::filesystem::path& bag, const Measurements& data, const BagForm& form = {});

/// A sensor file that fits `sensor`, with further lines; one that begins as a line that is there takes its place.
std::string sensor_text(const SensorModel& sensor, const std::vector<std::string>& lines = {});

struct How {
  std::string pipeline = "as_lio_plus";        ///< of configs/pipelines, or a path
  std::vector<std::string> set = {};           ///< overrides of the pipeline
  std::vector<std::string> sensor_lines = {};  ///< of the sensor file
  std::vector<std::string> options = {};       ///< further arguments
  BagForm form = {};
  std::function<void(const std::filesystem::path&)> damage = {};  ///< of the bag, once it is written
  std::filesystem::path output = {};                              ///< empty: a folder that is removed
  std::optional<std::size_t> file_limit = {};                     ///< no file may grow beyond so many bytes
  /// Called again and again with the process and its output folder until it returns true.
  std::function<bool(pid_t, const std::filesystem::path&)> during = {};
};

/// What a run left.
struct Outcome {
  int exit_code = -1;  ///< or 256 + the signal that ended it
  std::string err;
  nlohmann::json summary;          ///< null when there is none
  std::vector<std::string> files;  ///< names in the output folder
  std::string trajectory;          ///< text of trajectory.tum
  /// RMS of the position against the truth, after alignment [m]; nothing where that cannot be. The program is given no
  /// reference: what it says of itself is its own word.
  std::optional<double> ate;
  std::vector<TimeNs> times;                                ///< of updates.csv, as the next one
  std::vector<std::string> tracking;                        ///< status after the update
  std::map<std::string, std::vector<std::string>> updates;  ///< columns of updates.csv

  std::string status() const;
  std::string reason() const;
  /// A counter of the summary; 0 when there is none of that name.
  std::uint64_t count(const std::string& name) const;
  /// Of the first loss.
  std::optional<TimeNs> lost_at() const;
  /// The first update after `t` at which tracking is `status`.
  std::optional<TimeNs> first(const std::string& status, TimeNs t) const;
};

/// `truth` is for Outcome::ate alone.
Outcome run_over(const Measurements& data, const std::vector<StampedPose>& truth, const SensorModel& sensor,
                 const How& how = {});
/// The clean walk with a fault, against its own truth.
Outcome run_with(const Fault& fault, const How& how = {});
/// The clean walk itself. Made once per build of the program and pipeline.
Outcome run_clean(const std::string& pipeline = "as_lio_plus");

}  // namespace aslio::test::faults
