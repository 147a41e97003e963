#pragma once
/// The motion of the LiDAR by its points alone, with the IMU samples of the same time beside it.

#include <filesystem>
#include <string>
#include <vector>

#include "aslio/evaluation/turns.hpp"
#include "aslio/experiment/run.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::experiment {

struct LidarMotionOptions {
  std::filesystem::path pipeline;      ///< one whose estimator takes no IMU data, as ct_icp.yaml
  std::vector<std::string> overrides;  ///< `key.path=value` of it
  std::vector<std::filesystem::path> inputs;
  io::SensorConfig sensor;  ///< its T_imu_lidar is not used
  io::Section section;
  double enough = 60;    ///< [s] in motion after which no more is read
  double longest = 240;  ///< [s] of data after which no more is read, motion or not
};

struct LidarMotion {
  /// Poses T_W_L of accepted windows in a row, each at the middle of its window; W is another one in each stretch.
  std::vector<evaluation::MotionStretch> stretches;
  std::vector<ImuSample> imu;  ///< in order of time, as the sensor file makes them
  std::size_t windows = 0, accepted = 0;
  double data_s = 0, moving_s = 0;  ///< read, and of it in motion [s]
  double sweep_period = 0;          ///< median time between two LiDAR messages [s]; 0: unknown
  bool interrupted = false;
  std::vector<std::string> late_warnings;  ///< of the input
};

/// Runs the pipeline over the recording in a frame of the LiDAR. A run that is lost starts again, and its poses make
/// another stretch. Throws ConfigError for a pipeline that takes IMU data, DataError for an input that cannot be read.
LidarMotion read_lidar_motion(const LidarMotionOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor);

}  // namespace aslio::experiment
