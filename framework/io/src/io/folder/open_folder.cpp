#include "open_folder.hpp"

#include <fmt/format.h>

#include "../recording_source.hpp"
#include "aslio/core/errors.hpp"
#include "folder_reader.hpp"
#include "kitti_drive.hpp"
#include "kitti_recording.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

FolderRecording find_recording(const fs::path& path, const SensorConfig& sensor) {
  if (const auto drive = find_kitti_drive(path)) return kitti_recording(*drive, sensor);
  throw DataError(
      fmt::format("{}: this folder holds no KITTI raw drive (velodyne_points/ and oxts/); name a bag, or a drive folder",
                  path.string()));
}

/// Without the name of a topic that cannot be meant.
template <class Track>
std::string topic_in(const std::vector<Track>& tracks, const std::string& topic) {
  return tracks.size() == 1 ? std::string{} : topic;
}

}  // namespace

std::unique_ptr<MessageReader> open_folder(const fs::path& path, const SensorConfig& sensor) {
  return std::make_unique<FolderReader>(find_recording(path, sensor));
}

std::unique_ptr<MeasurementSource> open_folder_source(const fs::path& path, const SensorConfig& sensor,
                                                      const Section& section) {
  auto reader = std::make_unique<FolderReader>(find_recording(path, sensor));
  const std::string name = reader->recording().folder.string();
  SensorConfig chosen = sensor;
  chosen.lidar_topic = topic_in(reader->recording().lidars, sensor.lidar_topic);
  chosen.imu_topic = topic_in(reader->recording().imus, sensor.imu_topic);
  return open_recording(name, std::move(reader), chosen, section);
}

}  // namespace aslio::io
