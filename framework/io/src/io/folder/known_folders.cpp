// Layouts of public data sets, as their own documents and players have them.
#include <fmt/format.h>

#include <array>

#include "folder_path.hpp"
#include "folder_plan.hpp"
#include "imu_table.hpp"
#include "scan_list.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// A scan of that extension; empty where there is none.
fs::path scan_in(const fs::path& folder, std::string_view extension) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (is_scan_file(it->path()) && it->path().extension() == extension) return it->path();
  }
  return {};
}

/// Sequences of the odometry benchmark were cut from raw drives (readme of its development kit).
struct KittiSequence {
  std::string_view name, drive;
  int first, last;
};
constexpr std::array<KittiSequence, 11> kKittiSequences{{{"00", "2011_10_03_drive_0027", 0, 4540},
                                                         {"01", "2011_10_03_drive_0042", 0, 1100},
                                                         {"02", "2011_10_03_drive_0034", 0, 4660},
                                                         {"03", "2011_09_26_drive_0067", 0, 800},
                                                         {"04", "2011_09_30_drive_0016", 0, 270},
                                                         {"05", "2011_09_30_drive_0018", 0, 2760},
                                                         {"06", "2011_09_30_drive_0020", 0, 1100},
                                                         {"07", "2011_09_30_drive_0027", 0, 1100},
                                                         {"08", "2011_09_30_drive_0028", 1100, 5170},
                                                         {"09", "2011_09_30_drive_0033", 0, 1590},
                                                         {"10", "2011_09_30_drive_0034", 0, 1200}}};

std::string raw_drive_of(const fs::path& sequence) {
  const std::string name = named_folder(sequence).filename().string();
  for (const KittiSequence& known : kKittiSequences) {
    if (known.name == name) return fmt::format("{} (frames {} to {})", known.drive, known.first, known.last);
  }
  return "from which it was cut";
}

}  // namespace

std::optional<FolderPlan> plan_kitti_odometry(const fs::path& path) {
  if (!is_file(path / "times.txt") || scan_in(path / "velodyne", ".bin").empty()) return std::nullopt;
  FolderPlan plan;
  plan.kind = "KITTI odometry sequence";
  plan.folder = path;
  plan.lidars.push_back({"velodyne", path / "velodyne", "x y z intensity", kTimeMax, {}});
  for (const char* name : {"imu.csv", "imu.txt"}) {
    if (is_imu_table(path / name)) plan.imus.push_back({name, path / name, {}});
  }
  plan.verdicts.emplace_back("lidar points: corrected for motion beforehand, without times of their own");
  plan.without_imu = fmt::format(
      "the odometry benchmark of KITTI has none, and every run needs one, those of pipelines that do not use it "
      "included; take the raw drive {}, whose OXTS is an IMU",
      raw_drive_of(path));
  return plan;
}

std::optional<FolderPlan> plan_newer_college(const fs::path& path) {
  for (const fs::path& base : {path, path / "raw_format"}) {
    if (scan_in(base / "ouster_scan", ".pcd").empty()) continue;
    FolderPlan plan;
    plan.kind = "Newer College sequence";
    plan.folder = path;
    plan.lidars.push_back({"ouster_scan", base / "ouster_scan", {}, kTimeMax, {}});
    for (const fs::path& imu : {base / "ouster_imu.csv", base / "ouster_imu" / "ouster_imu.csv"}) {
      if (plan.imus.empty() && is_file(imu)) {
        plan.imus.push_back({"ouster_imu", imu, "counter sec nsec wx wy wz ax ay az"});
      }
    }
    plan.without_imu = "expected is ouster_imu.csv beside ouster_scan/ or in ouster_imu/";
    return plan;
  }
  return std::nullopt;
}

std::optional<FolderPlan> plan_boreas(const fs::path& path) {
  std::error_code ignored;
  const bool named = fs::is_directory(path / "applanix", ignored) || is_file(path / "calib" / "T_applanix_lidar.txt");
  if (!named || scan_in(path / "lidar", ".bin").empty()) return std::nullopt;
  FolderPlan plan;
  plan.kind = "Boreas sequence";
  plan.folder = path;
  plan.lidars.push_back({"lidar", path / "lidar", "x y z intensity ring time", kTimeMax, {}});
  if (!scan_in(path / "aeva", ".bin").empty()) {
    plan.lidars.push_back(
        {"aeva", path / "aeva", "x y z velocity intensity quality reflectivity time flags:f64", kTimeMax, {}});
  }
  const std::string columns = "time wx wy wz ax ay az";
  for (const char* name : {"dmu_imu", "aeva_imu"}) {
    const fs::path file = path / "imu" / (std::string(name) + ".csv");
    if (is_file(file)) plan.imus.push_back({name, file, columns});
  }
  for (const char* name : {"imu_raw.csv", "imu.csv"}) {
    const fs::path file = path / "applanix" / name;
    if (!plan.imus.empty() || !is_file(file)) continue;
    plan.imus.push_back({std::string("applanix/") + name, file, "time wz wy wx az ay ax"});
    plan.warnings.push_back(
        fmt::format("the samples of applanix/{} went into the reference trajectory, too: errors "
                    "against it come out too small",
                    name));
  }
  plan.verdicts.emplace_back("lidar stamps: of the middle of a sweep");
  plan.without_imu = "expected is imu/dmu_imu.csv, imu/aeva_imu.csv, applanix/imu_raw.csv or applanix/imu.csv";
  return plan;
}

std::optional<FolderPlan> plan_helipr(const fs::path& path) {
  FolderPlan plan;
  plan.kind = "HeLiPR sequence";
  plan.folder = path;
  for (const fs::path& folder : {path, path / "Inertial_data", path / "LiDAR" / "Inertial_data"}) {
    const fs::path imu = folder / "xsens_imu.csv";
    if (!plan.imus.empty() || !is_file(imu)) continue;
    plan.imus.push_back(
        {"xsens_imu", imu,
         "timestamp qx qy qz qw euler_x euler_y euler_z gyro_x gyro_y gyro_z acc_x acc_y acc_z mag_x mag_y "
         "mag_z"});
  }
  if (plan.imus.empty()) return std::nullopt;
  const std::string aeva = "x y z reflectivity velocity offset_time:i32 ring:u8";
  constexpr TimeNs kAevaIntensity = 1'691'936'557'946'849'180;  // scans from then on have it
  const std::array<LidarPlan, 4> known{
      {{"Aeva", {}, aeva, kAevaIntensity, aeva + " intensity"},
       {"Avia", {}, "x y z reflectivity:u8 tag:u8 line:u8 offset_time:u32", kTimeMax, {}},
       {"Ouster", {}, "x y z intensity t:u32 reflectivity:u16 ring:u16 ambient:u16", kTimeMax, {}},
       {"Velodyne", {}, "x y z intensity ring:u16 time", kTimeMax, {}}}};
  for (const fs::path& base : {path, path / "LiDAR"}) {
    for (LidarPlan lidar : known) {
      lidar.folder = base / lidar.topic;
      const fs::path scan = scan_in(lidar.folder, ".bin");
      if (scan.empty()) continue;
      // MulRan has folders and an IMU of the same names, but points of 16 bytes.
      constexpr std::uintmax_t kOusterPoint = 26, kMulranPoint = 16;
      std::error_code ignored;
      const std::uintmax_t bytes = fs::file_size(scan, ignored);
      if (lidar.topic == "Ouster" && bytes % kOusterPoint != 0 && bytes % kMulranPoint == 0) return std::nullopt;
      plan.lidars.push_back(std::move(lidar));
    }
  }
  if (plan.lidars.empty()) return std::nullopt;
  return plan;
}

}  // namespace aslio::io
