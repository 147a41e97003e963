#pragma once
/// ROS1 messages as ROS2 stores them, and copies of recordings.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/io/message_writer.hpp"

namespace aslio::io {

/// package/Name -> package/msg/Name; a name of ROS2 stays as it is.
std::string ros2_type(const std::string& type);

/// A definition of rosbag/messages.hpp as ROS2 has it: the header without `seq`, times as builtin_interfaces/Time.
std::string ros2_definition(std::string_view ros1);

/// Serialises an Imu, PointCloud2, Livox CustomMsg, VelodyneScan, PoseStamped or PointStamped of ROS1 as plain CDR,
/// little-endian. All values stay; `seq` of the header goes, as ROS2 has none. Empty text, or why the message cannot be
/// converted.
std::string to_cdr(const Connection& ros1, std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out);

/// Copies all messages in their order; those of ROS1 become CDR where `encoding` says so. Connections of a type that
/// cannot be converted are left out. Does not close the writer. Returns the topics that were left out.
std::vector<std::string> copy_messages(MessageReader& from, MessageWriter& to, Encoding encoding);

}  // namespace aslio::io
