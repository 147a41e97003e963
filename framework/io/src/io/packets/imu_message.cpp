#include "imu_message.hpp"

#include "aslio/io/rosbag/messages.hpp"
#include "ouster.hpp"
#include "velodyne.hpp"

namespace aslio::io::packets {

Connection imu_connection(std::uint32_t id, std::string topic) {
  Connection connection;
  connection.id = id;
  connection.topic = std::move(topic);
  connection.type = std::string(rosbag::kImu.name);
  connection.md5 = std::string(rosbag::kImu.md5);
  return connection;
}

std::string encode_ouster_imu(Bytes packet, TimeNs received, SensorClock& clock, std::vector<std::uint8_t>& out) {
  OusterImu imu;
  std::string why = decode_ouster_imu(packet, imu);
  if (why.empty()) rosbag::encode_imu({0, clock.to_receiver(imu.time, received), "imu"}, imu.gyro, imu.acc, out);
  return why;
}

std::string encode_velodyne_imu(Bytes packet, TimeNs received, SensorClock& clock, std::vector<std::uint8_t>& out) {
  VelodynePosition position;
  std::string why = decode_velodyne_position(packet, position);
  if (!why.empty()) return why;
  rosbag::encode_imu({0, clock.to_receiver(position.time, received), "imu"}, position.gyro, position.acc, out);
  return {};
}

}  // namespace aslio::io::packets
