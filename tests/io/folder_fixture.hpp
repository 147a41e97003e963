#pragma once
/// Small folders of scans, made to measure.

#include <filesystem>
#include <functional>
#include <string>

#include "io/bag_fixture.hpp"

namespace aslio::io::test {

/// One second: `lidar/` with ten scans of 40 points, and imu.csv at 100 Hz. Each part may be changed.
struct ScanFolder {
  std::string columns = "x y z intensity time ring";  ///< all float32; fewer: the first of them
  std::string extension = ".bin";
  TimeNs start = kStart, imu_shift = 0;
  bool counted = false;                                    ///< scans are named 0, 1, ..
  std::function<std::string(TimeNs stamp)> name;           ///< of a scan, without extension; null: ns
  std::string imu_header = "timestamp,wx,wy,wz,ax,ay,az";  ///< empty: none
  std::function<std::string(TimeNs t)> imu_time;           ///< null: ns
  std::string imu_file = "imu.csv", lidar_folder = "lidar";

  void write(const std::filesystem::path& root) const;
};

}  // namespace aslio::io::test
