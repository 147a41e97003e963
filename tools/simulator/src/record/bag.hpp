#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/writer.hpp"
#include "aslio/simulator/simulation.hpp"

namespace aslio::simulator {

/// The bag of a recording: messages as the drivers of the sensors send them, in the order in which they would arrive,
/// with what a stress study does to them.
class RecordingBag {
 public:
  RecordingBag(const Simulation& simulation, const std::filesystem::path& path, bool compress);

  /// Packets in order; IMU samples go between them.
  void add(const LidarPacket& packet, std::size_t index);
  /// Writes the IMU samples left and gives the bag its name.
  void close();

  std::size_t lidar_messages() const { return lidar_count_; }
  std::size_t imu_messages() const { return imu_count_; }

 private:
  void add_imu_until(TimeNs arrival);
  void encode(const LidarPacket& packet);
  void encode_livox(const LidarPacket& packet);
  void encode_cloud(const LidarPacket& packet);
  io::rosbag::HeaderFields header(std::uint32_t seq, TimeNs stamp) const;

  const Simulation& simulation_;
  const SensorFacts& facts_;
  io::rosbag::BagWriter bag_;
  bool livox_;
  std::uint32_t lidar_ = 0, imu_ = 0, lidar_count_ = 0, imu_count_ = 0;
  std::size_t next_imu_ = 0;
  TimeNs last_imu_stamp_ = 0;
  RandomStream jitter_, imu_loss_;
  std::vector<std::uint8_t> bytes_, data_;
  std::vector<io::rosbag::LivoxPoint> livox_points_;
};

}  // namespace aslio::simulator
