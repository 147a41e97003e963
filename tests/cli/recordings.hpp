#pragma once
/// Small recordings of the analytic world, whole or with one thing wrong.

#include <filesystem>
#include <string>

namespace aslio::test {

struct Recording {
  double duration = 2.0;                   ///< [s] of the world's walk, which starts at rest
  double slowness = 1.0;                   ///< divides all speeds of the walk, up to 100
  double blind_from = 0, blind_until = 0;  ///< [s] no LiDAR message begins within
  std::string lidar_topic = "/livox/lidar";
  bool imu = true;
  bool acc_in_g = true;
  int nan_every = 0;         ///< every so many point is not a number; 0: none
  bool point_cloud = false;  ///< sensor_msgs/PointCloud2 in place of the Livox message
  bool zero_times = false;   ///< of a point cloud: the time field is there and filled with zeros
};

/// Writes a bag; the LiDAR has an identity extrinsic.
void write_bag(const std::filesystem::path& bag, const Recording& recording = {});
/// True poses of the IMU over the 2 s.
void write_truth(const std::filesystem::path& tum);

/// Sensor file text that fits, with further lines.
std::string sensor_text(const std::string& more = "");
/// A pipeline that is quick and complete.
std::string pipeline_text(const std::string& more = "");

}  // namespace aslio::test
