#include "open_folder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "../recording_source.hpp"
#include "aslio/core/errors.hpp"
#include "folder_plan.hpp"
#include "folder_reader.hpp"
#include "kitti_drive.hpp"
#include "kitti_recording.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExpected =
    "\n  KITTI raw drive: velodyne_points/ and oxts/"
    "\n  KITTI odometry sequence: velodyne/ and times.txt"
    "\n  HeLiPR sequence: Aeva/, Avia/, Ouster/ or Velodyne/, and xsens_imu.csv"
    "\n  Boreas sequence: lidar/, and imu/ or applanix/"
    "\n  Newer College sequence: ouster_scan/ and ouster_imu.csv"
    "\n  folder of scans: .pcd, .ply or .bin files named by their times, and a table of an IMU (.csv, .txt) whose "
    "first "
    "line names its columns";

FolderRecording find_recording(const fs::path& path, const SensorConfig& sensor) {
  if (const auto drive = find_kitti_drive(path)) return kitti_recording(*drive, sensor);
  for (const auto plan_known : {&plan_kitti_odometry, &plan_helipr, &plan_boreas, &plan_newer_college}) {
    if (const auto plan = plan_known(path)) return load_folder(*plan, sensor);
  }
  if (const auto plan = plan_any_folder(path, sensor)) return load_folder(*plan, sensor);
  throw DataError(
      fmt::format("{}: this folder holds no recording that can be read; it holds {}; expected is a bag, or one of:{}",
                  path.string(), holdings(path), kExpected));
}

/// Without the name of a topic that cannot be meant.
template <class Track>
std::string topic_in(const std::vector<Track>& tracks, const std::string& topic) {
  return tracks.size() == 1 ? std::string{} : topic;
}

void require_imu(const FolderRecording& recording) {
  if (!recording.imus.empty()) return;
  throw DataError(fmt::format("{}: there is no IMU in this {}: {}", recording.folder.string(), recording.kind,
                              recording.without_imu));
}

struct Extent {
  TimeNs begin = kTimeMax, end = kTimeMin;

  void add(TimeNs t) {
    begin = std::min(begin, t);
    end = std::max(end, t);
  }
  std::string text() const { return fmt::format("from {:.3f} to {:.3f} s", to_seconds(begin), to_seconds(end)); }
};

/// nullptr where none is named, or no such.
template <class Track>
const Track* chosen(const std::vector<Track>& tracks, const std::string& topic) {
  if (tracks.size() == 1) return &tracks.front();
  const auto found = std::find_if(tracks.begin(), tracks.end(), [&](const Track& t) { return t.topic == topic; });
  return found == tracks.end() ? nullptr : &*found;
}

/// Odometry with times that never meet would fail later, and not say why.
void require_common_time(const FolderRecording& recording, const SensorConfig& sensor) {
  constexpr TimeNs kApart = kSecond;
  const ScanTrack* lidar = chosen(recording.lidars, sensor.lidar_topic);
  const ImuTrack* imu = chosen(recording.imus, sensor.imu_topic);
  if (lidar == nullptr || imu == nullptr) return;
  Extent scans, samples;
  for (const ScanFile& scan : lidar->scans) scans.add(scan.stamp);
  for (const ImuSample& sample : imu->samples) samples.add(sample.t);
  const bool empty = scans.begin > scans.end || samples.begin > samples.end;
  if (empty || (samples.begin <= scans.end + kApart && samples.end >= scans.begin - kApart)) return;
  throw DataError(fmt::format(
      "{}: the scans of {} ({}) and the IMU samples of {} ({}) do not meet: their clocks differ, or they are of two "
      "recordings; give the stamps of both in one clock",
      recording.folder.string(), lidar->topic, scans.text(), imu->topic, samples.text()));
}

}  // namespace

std::unique_ptr<MessageReader> open_folder(const fs::path& path, const SensorConfig& sensor) {
  return std::make_unique<FolderReader>(find_recording(path, sensor));
}

std::unique_ptr<MeasurementSource> open_folder_source(const fs::path& path, const SensorConfig& sensor,
                                                      const Section& section) {
  auto reader = std::make_unique<FolderReader>(find_recording(path, sensor));
  const std::string name = reader->recording().folder.string();
  require_imu(reader->recording());
  require_common_time(reader->recording(), sensor);
  SensorConfig chosen = sensor;
  chosen.lidar_topic = topic_in(reader->recording().lidars, sensor.lidar_topic);
  chosen.imu_topic = topic_in(reader->recording().imus, sensor.imu_topic);
  return open_recording(name, std::move(reader), chosen, section);
}

}  // namespace aslio::io
