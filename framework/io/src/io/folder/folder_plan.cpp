#include "folder_plan.hpp"

#include <fmt/format.h>

#include <memory>

#include "file_columns.hpp"
#include "imu_table.hpp"
#include "point_file.hpp"
#include "scan_list.hpp"

namespace aslio::io {
namespace {

struct LidarFiles {
  std::vector<ScanFile> scans;
  FileColumns columns, later_columns;
  TimeNs later_from = kTimeMax;

  void read(std::size_t i, PointTable& table) const {
    const ScanFile& scan = scans[i];
    read_point_file(scan.path, scan.stamp >= later_from ? later_columns : columns, table);
  }
};

ScanTrack load_lidar(const LidarPlan& plan, const SensorConfig& sensor, std::vector<std::string>& verdicts) {
  auto files = std::make_shared<LidarFiles>();
  std::string verdict;
  files->scans = list_scans(plan.folder, sensor.model.sweep_period, verdict);
  const auto columns_of = [&](const std::string& columns) {
    return columns.empty() ? FileColumns{} : declared_columns(columns, plan.folder.string());
  };
  files->columns = columns_of(plan.columns);
  files->later_columns = columns_of(plan.later_columns);
  files->later_from = plan.later_from;
  if (!verdict.empty()) verdicts.push_back(verdict);
  ScanTrack track;
  track.topic = plan.topic;
  track.scans = files->scans;
  track.read = [files](std::size_t i, PointTable& table) { files->read(i, table); };
  return track;
}

}  // namespace

FolderRecording load_folder(const FolderPlan& plan, const SensorConfig& sensor) {
  FolderRecording recording;
  recording.kind = plan.kind;
  recording.folder = plan.folder;
  recording.verdicts = plan.verdicts;
  recording.warnings = plan.warnings;
  recording.without_imu = plan.without_imu;
  for (const LidarPlan& lidar : plan.lidars) {
    recording.lidars.push_back(load_lidar(lidar, sensor, recording.verdicts));
  }
  for (const ImuPlan& imu : plan.imus) {
    const std::string columns = imu.columns.empty() ? sensor.imu_columns : imu.columns;
    recording.imus.push_back({imu.topic, read_imu_table(imu.file, columns, recording.verdicts, recording.warnings)});
  }
  return recording;
}

}  // namespace aslio::io
