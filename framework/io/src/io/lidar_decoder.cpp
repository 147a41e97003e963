#include "lidar_decoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "aslio/core/errors.hpp"
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

/// A key that a kind of message does not read would be taken for heeded.
void refuse_unread_keys(MessageKind kind, const SensorConfig& sensor, const std::string& where) {
  const InputTimes& t = sensor.times;
  const bool cloud = kind == MessageKind::cloud, packets = kind == MessageKind::packets;
  const bool from_start = t.point_time == PointTime::automatic || t.point_time == PointTime::none;
  const std::array<std::pair<std::string_view, bool>, 7> unread{
      {{"point_time_field", !cloud && !t.point_time_field.empty()},
       {"point_time_unit", !cloud && t.point_time_unit != TimeUnit::automatic},
       {"point_time", packets ? t.point_time != PointTime::automatic : !cloud && !from_start},
       {"lidar_stamp", packets && t.lidar_stamp != LidarStamp::automatic},
       {"deskewed", packets && t.deskewed},
       {"lidar_frame", !cloud && !sensor.lidar_frame.empty()},
       {"lidar_id", kind != MessageKind::livox && sensor.lidar_id >= 0}}};
  for (const auto& [key, is_set] : unread) {
    if (!is_set) continue;
    throw DataError(fmt::format("{}: `{}` of the sensor file has no meaning for {}; remove it", where, key,
                                cloud     ? "PointCloud2"
                                : packets ? "raw packets"
                                          : "a Livox CustomMsg"));
  }
}

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
  refuse_unread_keys(kind, sensor, where);
  if (kind == MessageKind::livox) return make_livox_decoder(sensor, std::move(where));
  if (kind == MessageKind::packets) return packets::make_sweep_decoder(connection, sensor, std::move(where));
  return make_cloud_decoder(sensor, std::move(where), imu_time);
}

}  // namespace aslio::io
