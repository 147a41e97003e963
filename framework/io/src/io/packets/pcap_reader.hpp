#pragma once
/// A network capture of one LiDAR as messages: sweeps of packets (sweep_message.hpp) on the topic `lidar`, and where
/// the sensor has an IMU, sensor_msgs/Imu on `imu`.

#include <filesystem>
#include <memory>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io::packets {

/// Reads the capture once for its extent and its sensors. Throws DataError when it holds the packets of no known
/// sensor, of several without a choice, or of an Ouster without its metadata.
std::unique_ptr<MessageReader> open_capture(const std::filesystem::path& path, const SensorConfig& sensor);

/// Metadata of an Ouster for a recording: the file that the sensor file names, or one beside the recording of its name
/// (`a.json` for `a.pcap`), or of the longest begin of that name. Empty where there is none. Throws DataError where the
/// named one cannot be read.
struct MetadataFile {
  std::filesystem::path path;
  std::string text;
};
MetadataFile find_metadata(const std::filesystem::path& recording, const SensorConfig& sensor);

}  // namespace aslio::io::packets
