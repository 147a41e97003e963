#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "aslio/io/layout.hpp"

namespace aslio::experiment {

/// The block `stand_in` of a family file: what else than the keys of a reader a writer has to know.
struct StandInConfig {
  io::Container container = io::Container::rosbag;
  io::LidarForm points = io::LidarForm::velodyne;
  std::vector<std::string> files;  ///< in place of the patterns of `input`; see io::Layout::files
  std::int64_t parts = 1;
  io::Packing compression = io::Packing::none;
  io::PointOrder order = io::PointOrder::column;
  bool organised = false;
  std::int64_t columns = 1000;  ///< of the published sensor
  io::TimeUnit name_unit = io::TimeUnit::ns;
  double imu_rate = 0;                   ///< [Hz]; 0: the block is not there
  bool sensor_noise = true;              ///< that of the sensor file is simulated; false: that of the scene
  std::vector<std::string> imu_columns;  ///< of a table; empty: those of the sensor file
  bool imu_header = false;
  io::TimeUnit imu_time_unit = io::TimeUnit::ns;
  double reference_rate = 10;  ///< [Hz]
  std::string reference_separator = ",";
  bool reference_header = false;
  std::vector<double> reference_origin{0, 0, 0};  ///< [m]
  double begin = 1'700'000'000;                   ///< [s]

  bool given() const { return imu_rate > 0; }
  static void describe(config::Binder& b, StandInConfig& config);
};

}  // namespace aslio::experiment
