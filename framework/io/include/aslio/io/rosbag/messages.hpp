#pragma once
/// The ROS1 messages this project knows: names, checksums, definitions, and encoders for writers.
/// Messages are recognised by checksum: livox_ros_driver and livox_ros_driver2 differ only in the package name.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/types.hpp"

namespace aslio::io::rosbag {

struct MessageType {
  std::string_view name, md5, definition;
};

extern const MessageType kLivoxCustomMsg;   ///< livox_ros_driver/CustomMsg
extern const MessageType kLivox2CustomMsg;  ///< livox_ros_driver2/CustomMsg
extern const MessageType kImu;              ///< sensor_msgs/Imu
extern const MessageType kPointCloud2;      ///< sensor_msgs/PointCloud2

extern const MessageType kPoseStamped;   ///< geometry_msgs/PoseStamped
extern const MessageType kPointStamped;  ///< geometry_msgs/PointStamped
extern const MessageType kVelodyneScan;  ///< velodyne_msgs/VelodyneScan

struct HeaderFields {
  std::uint32_t seq = 0;
  TimeNs stamp = 0;  ///< [ns], 0 or later
  std::string frame_id;
};

struct LivoxPoint {
  std::uint32_t offset_time = 0;  ///< [ns] from the time base
  float x = 0, y = 0, z = 0;      ///< [m]
  std::uint8_t reflectivity = 0, tag = 0, line = 0;
};

/// Each encoder replaces the content of `out` (and keeps its capacity).
void encode_livox(const HeaderFields& header, TimeNs timebase, std::uint8_t lidar_id,
                  std::span<const LivoxPoint> points, std::vector<std::uint8_t>& out);
/// Writes angular rate and acceleration as given, in whatever unit; no orientation (covariance[0] = -1).
void encode_imu(const HeaderFields& header, const Vec3& gyro, const Vec3& acc, std::vector<std::uint8_t>& out);

void encode_pose(const HeaderFields& header, const Pose& pose, std::vector<std::uint8_t>& out);
void encode_point(const HeaderFields& header, const Vec3& position, std::vector<std::uint8_t>& out);

/// velodyne_msgs/VelodynePacket: the data packet of a sensor, as it came.
struct VelodynePacketFields {
  TimeNs stamp = 0;  ///< when it was received [ns]
  std::array<std::uint8_t, 1206> data{};
};
void encode_velodyne_scan(const HeaderFields& header, std::span<const VelodynePacketFields> packets,
                          std::vector<std::uint8_t>& out);

struct PointField {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;  ///< 1..8 = int8, uint8, int16, uint16, int32, uint32, float32, float64
  std::uint32_t count = 1;
};
struct CloudLayout {
  std::uint32_t height = 1, width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;
  bool is_dense = true;
};
void encode_point_cloud2(const HeaderFields& header, const CloudLayout& layout, std::span<const std::uint8_t> data,
                         std::vector<std::uint8_t>& out);

}  // namespace aslio::io::rosbag
