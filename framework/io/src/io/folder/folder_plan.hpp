#pragma once
/// Where a kind of folder has its scans and IMU samples.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/io/source.hpp"
#include "folder_recording.hpp"

namespace aslio::io {

struct LidarPlan {
  std::string topic;
  std::filesystem::path folder;
  std::string columns;           ///< of .bin files, as declared_columns() takes them
  TimeNs later_from = kTimeMax;  ///< scans from then on ..
  std::string later_columns;     ///< .. have these
};

struct ImuPlan {
  std::string topic;
  std::filesystem::path file;
  std::string columns;  ///< where the file names none
};

struct FolderPlan {
  std::string kind;
  std::filesystem::path folder;
  std::vector<LidarPlan> lidars;
  std::vector<ImuPlan> imus;
  std::vector<std::string> verdicts, warnings;
  std::string without_imu;  ///< what to do where there is no IMU
};

/// Lists the scans and reads the IMU samples. Throws DataError.
FolderRecording load_folder(const FolderPlan& plan, const SensorConfig& sensor);

/// Folders of public data sets; nullopt where `path` is none. Velodyne scans of KITTI's odometry benchmark with
/// times.txt.
std::optional<FolderPlan> plan_kitti_odometry(const std::filesystem::path& path);
/// The raw format of the Newer College Dataset (2020): ouster_scan/cloud_SEC_NSEC.pcd, ouster_imu.csv.
std::optional<FolderPlan> plan_newer_college(const std::filesystem::path& path);
/// Boreas and Boreas Road Trip: lidar/US.bin, aeva/US.bin, imu/*.csv or applanix/imu*.csv.
std::optional<FolderPlan> plan_boreas(const std::filesystem::path& path);
/// HeLiPR: Aeva, Avia, Ouster and Velodyne with NS.bin, xsens_imu.csv.
std::optional<FolderPlan> plan_helipr(const std::filesystem::path& path);

/// Any folder with scans (.bin, .pcd, .ply) in it or up to two folders below, each folder a LiDAR; tables that name the
/// columns of an IMU are IMUs. nullopt where there is no scan. Throws DataError for .bin files without `scan_columns`.
std::optional<FolderPlan> plan_any_folder(const std::filesystem::path& path, const SensorConfig& sensor);

/// What a folder holds, in words: files by their extensions, and folders.
std::string holdings(const std::filesystem::path& path);

}  // namespace aslio::io
