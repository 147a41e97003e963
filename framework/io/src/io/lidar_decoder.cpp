#include "lidar_decoder.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "aslio/io/rosbag/messages.hpp"
#include "cloud_decoder.hpp"
#include "livox_decoder.hpp"
#include "packets/sweep_decoder.hpp"

namespace aslio::io {
namespace {

/// A message that can be decoded, by ROS1's checksum or by its name: package/Name, package/msg/Name in ROS2.
struct KnownMessage {
  MessageKind kind;
  const rosbag::MessageType* ros1;
  std::string_view package, name;  ///< package: the begin of it

  bool named(std::string_view type) const { return type.starts_with(package) && type.ends_with(name); }
};

/// Forks of Livox's driver have names of their own (livox_ros_driver, livox_ros_driver2, livox_interfaces).
constexpr std::array<KnownMessage, 3> kKnownMessages{
    {{MessageKind::livox, &rosbag::kLivoxCustomMsg, "livox_", "/CustomMsg"},
     {MessageKind::cloud, &rosbag::kPointCloud2, "sensor_msgs/", "/PointCloud2"},
     {MessageKind::imu, &rosbag::kImu, "sensor_msgs/", "/Imu"}}};

}  // namespace

MessageKind message_kind(const Connection& connection) {
  const bool ros1 = connection.encoding == Encoding::ros1;
  if (connection.encoding == Encoding::other) return MessageKind::other;
  if (packets::vendor_of(connection)) return MessageKind::packets;
  const bool by_name = !ros1 || connection.md5.empty() || connection.md5 == "*";
  for (const KnownMessage& known : kKnownMessages) {
    if (by_name ? known.named(connection.type) : known.ros1->md5 == connection.md5) return known.kind;
  }
  return MessageKind::other;
}

bool is_known_name(const Connection& connection) {
  return std::any_of(kKnownMessages.begin(), kKnownMessages.end(),
                     [&](const KnownMessage& known) { return known.named(connection.type); });
}

bool is_lidar(const Connection& connection) {
  const MessageKind kind = message_kind(connection);
  return kind == MessageKind::livox || kind == MessageKind::cloud || kind == MessageKind::packets;
}

bool is_imu(const Connection& connection) { return message_kind(connection) == MessageKind::imu; }

std::unique_ptr<LidarDecoder> make_lidar_decoder(const Connection& connection, const SensorConfig& sensor,
                                                 std::string where, std::optional<TimeNs> imu_time) {
  const MessageKind kind = message_kind(connection);
  if (kind == MessageKind::livox) return make_livox_decoder(sensor, std::move(where));
  if (kind == MessageKind::packets) return packets::make_sweep_decoder(connection, sensor, std::move(where));
  return make_cloud_decoder(sensor, std::move(where), imu_time);
}

}  // namespace aslio::io
