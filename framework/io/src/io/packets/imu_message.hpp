#pragma once
/// Inertial samples of a LiDAR's own packets as sensor_msgs/Imu of ROS1.

#include <vector>

#include "aslio/io/message_reader.hpp"
#include "format.hpp"
#include "sensor_clock.hpp"

namespace aslio::io::packets {

/// Connection of such messages.
Connection imu_connection(std::uint32_t id, std::string topic);

/// Replaces the content of `out`. Empty, or what is wrong with the packet.
std::string encode_ouster_imu(Bytes packet, TimeNs received, SensorClock& clock, std::vector<std::uint8_t>& out);
std::string encode_velodyne_imu(Bytes packet, TimeNs received, SensorClock& clock, std::vector<std::uint8_t>& out);

}  // namespace aslio::io::packets
