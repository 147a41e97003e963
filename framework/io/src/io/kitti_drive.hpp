#pragma once
/// One drive of the KITTI raw recordings (Geiger et al., IJRR 2013), as a folder of files.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/core/measurement.hpp"

namespace aslio::io {

struct KittiScan {
  TimeNs begin = 0, end = 0;
  std::filesystem::path file;
};

struct KittiDrive {
  std::filesystem::path folder;
  std::vector<KittiScan> scans;                    ///< by number; those that are missing are left out
  std::vector<ImuSample> imu;                      ///< of the OXTS unit, in the units of its files [rad/s, m/s^2]
  std::size_t missing_scans = 0, missing_imu = 0;  ///< listed, with a time or an empty line, but without a file
  std::optional<Pose> T_imu_velo;                  ///< from calib_imu_to_velo.txt, inverted
};

/// The drive folder that `path` is or contains (a date folder, or the root above); nullopt when it is no KITTI folder.
/// Throws DataError when there are several.
std::optional<std::filesystem::path> find_kitti_drive(const std::filesystem::path& path);

/// Reads everything but the points. Throws DataError with file:line.
KittiDrive read_kitti_drive(const std::filesystem::path& folder);

/// Points of one scan with their times t_begin + (t_end - t_begin) (pi - atan2(y, x)) / (2 pi): the sensor turns
/// clockwise and passes the rear at both ends. Returns the number of bytes left over (a file cut short), else 0.
std::size_t read_kitti_scan(const KittiScan& scan, LidarPacket& packet);

}  // namespace aslio::io
