#pragma once
/// Recordings of Ouster's driver without clouds: messages that hold one packet each (ouster_ros/PacketMsg,
/// ouster_sensor_msgs/msg/PacketMsg), and the metadata as a std_msgs/String.

#include <filesystem>
#include <memory>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io::packets {

/// The recording with sweeps (sweep_message.hpp) in place of LiDAR packets and sensor_msgs/Imu in place of IMU packets;
/// other topics, and a recording without such packets, as they are. So it is, too, where clouds or other LiDAR messages
/// are there and `lidar_topic` names no packets. Throws DataError where packets are the only LiDAR data and their
/// metadata is neither in the recording nor beside it.
std::unique_ptr<MessageReader> unpack_ouster(std::unique_ptr<MessageReader> reader,
                                             const std::filesystem::path& recording, const SensorConfig& sensor);

}  // namespace aslio::io::packets
