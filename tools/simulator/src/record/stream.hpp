#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "aslio/core/trajectory.hpp"
#include "aslio/io/layout_writer.hpp"
#include "aslio/simulator/random.hpp"
#include "aslio/simulator/record.hpp"

namespace aslio::simulator {

/// The measurements of a recording in the order in which they would arrive, with what a stress study does to them.
class RecordingStream {
 public:
  /// `truth` gives the poses of a reference that the layout has. A sweep period that is a part of a packet's, 0.05 s
  /// say, makes so many sweeps of each.
  RecordingStream(const Simulation& simulation, const Trajectory& truth, const RecordLayout& layout);

  /// Packets in order; IMU samples and poses go between them.
  void add(const LidarPacket& packet, std::size_t index);
  /// Writes what is left and gives the files their names.
  void close();

  std::size_t lidar_messages() const { return lidar_count_; }
  std::size_t imu_messages() const { return imu_count_; }
  /// Relative to the folder of the place.
  const std::vector<std::filesystem::path>& files() const { return writer_->files(); }

 private:
  void add_imu_until(TimeNs arrival);
  void add_truth_until(TimeNs time);

  const Simulation& simulation_;
  const Trajectory& truth_;
  std::unique_ptr<io::LayoutWriter> writer_;
  TimeNs sweep_period_;
  int lines_;
  std::size_t lidar_count_ = 0, imu_count_ = 0, next_imu_ = 0, next_truth_ = 0;
  TimeNs last_imu_stamp_ = 0;
  RandomStream jitter_, imu_loss_;
  double imu_clock_rate_ = 0;  ///< seconds that the clock of the IMU gains in one second
  double jitter_us_ = 0;       ///< standard deviation of the stamps of the IMU
};

}  // namespace aslio::simulator
