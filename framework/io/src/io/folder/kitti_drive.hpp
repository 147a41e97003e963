#pragma once
/// One drive of the KITTI raw recordings (Geiger et al., IJRR 2013), synchronised or as it was recorded.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/lie.hpp"
#include "folder_recording.hpp"

namespace aslio::io {

struct KittiScan {
  TimeNs begin = 0, end = 0;
  std::filesystem::path file;  ///< float32 x y z reflectance; .txt: lines of these
};

struct KittiDrive {
  std::filesystem::path folder, oxts;              ///< oxts: whose packets were read
  std::vector<KittiScan> scans;                    ///< by number; those that are missing are left out
  std::vector<ImuSample> imu;                      ///< of the OXTS unit, in the units of its files [rad/s, m/s^2]
  std::size_t missing_scans = 0, missing_imu = 0;  ///< listed, with a time or an empty line, but without a file
  std::optional<Pose> T_imu_velo;                  ///< from calib_imu_to_velo.txt, inverted
};

/// The drive folder that `path` is or contains (a date folder, or the root above); nullopt when it is no KITTI folder.
/// Throws DataError when there are several.
std::optional<std::filesystem::path> find_kitti_drive(const std::filesystem::path& path);

/// Reads everything but the points. A synchronised drive has the packets of OXTS at 10 Hz: where the unsynchronised
/// one lies beside it (`_extract`), those at 100 Hz are taken. Throws DataError with file:line.
KittiDrive read_kitti_drive(const std::filesystem::path& folder);

/// Points of one scan: x, y, z, intensity, t (ns from its begin), ring. Times are
/// (t_end - t_begin) (pi - atan2(y, x)) / (2 pi): the sensor turns clockwise and passes the rear at both ends.
void read_kitti_scan(const KittiScan& scan, PointTable& table);

}  // namespace aslio::io
