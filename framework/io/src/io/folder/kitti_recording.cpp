#include "kitti_recording.hpp"

#include <fmt/format.h>

#include <memory>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "kitti_drive.hpp"

namespace aslio::io {
namespace {

void note_missing(const KittiDrive& drive, std::vector<std::string>& warnings) {
  if (drive.missing_scans > 0) warnings.push_back(fmt::format("{} scans are listed but missing", drive.missing_scans));
  if (drive.missing_imu > 0) {
    warnings.push_back(fmt::format("{} OXTS packets are listed but missing", drive.missing_imu));
  }
}

/// `T_imu_lidar`: of the sensor file.
void compare_extrinsic(const KittiDrive& drive, const Pose& T_imu_lidar, std::vector<std::string>& warnings) {
  if (!drive.T_imu_velo) return;
  const Pose difference = drive.T_imu_velo->inverse() * T_imu_lidar;
  const double degrees = log_so3(difference.R).norm() * kDegPerRad;
  if (difference.p.norm() <= 1e-3 && degrees <= 0.01) return;
  warnings.push_back(
      fmt::format("T_imu_lidar of the sensor file is {:.1f} mm and {:.3f} deg away from calib_imu_to_velo.txt; the "
                  "sensor file counts",
                  1e3 * difference.p.norm(), degrees));
}

}  // namespace

FolderRecording kitti_recording(const std::filesystem::path& folder, const SensorConfig& sensor) {
  const auto drive = std::make_shared<const KittiDrive>(read_kitti_drive(folder));
  FolderRecording recording;
  recording.kind = "KITTI raw drive";
  recording.folder = folder;
  ScanTrack lidar;
  lidar.topic = "velodyne_points";
  for (const KittiScan& scan : drive->scans) lidar.scans.push_back({scan.begin, scan.file});
  lidar.read = [drive](std::size_t i, PointTable& table) { read_kitti_scan(drive->scans[i], table); };
  recording.lidars.push_back(std::move(lidar));
  recording.imus.push_back({"oxts", drive->imu});
  recording.verdicts.emplace_back("lidar points: timed by the azimuth between timestamps_start and timestamps_end");
  if (drive->oxts != folder / "oxts") {
    recording.verdicts.push_back(
        fmt::format("imu samples: of the unsynchronised drive beside this one, {}", drive->oxts.string()));
  }
  note_missing(*drive, recording.warnings);
  if (sensor.from_file) compare_extrinsic(*drive, sensor.model.T_imu_lidar, recording.warnings);
  return recording;
}

}  // namespace aslio::io
