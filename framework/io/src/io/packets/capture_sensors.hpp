#pragma once
/// Which sensors a capture holds, and which one is meant.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture_file.hpp"
#include "sweep_decoder.hpp"

namespace aslio::io::packets {

/// The sensor whose packets are read.
struct CaptureSensor {
  Vendor vendor = Vendor::velodyne;
  std::string address;
  std::uint16_t port = 0;  ///< that its LiDAR packets are sent to
  std::string metadata;    ///< of an Ouster
  std::unique_ptr<PacketFormat> format;
  bool has_imu = false;
  TimeNs begin = 0, end = 0;  ///< of all datagrams of the capture

  /// Packets of the LiDAR; and those of its IMU, which go to another port.
  bool is_lidar(const Datagram& datagram) const;
  bool is_imu(const Datagram& datagram) const;
};

/// Reads all of the capture. Throws DataError (open_capture).
CaptureSensor find_sensor(CaptureFile& capture, const std::filesystem::path& path, const SensorConfig& sensor);

}  // namespace aslio::io::packets
