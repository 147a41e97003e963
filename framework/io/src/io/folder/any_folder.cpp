#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "aslio/core/errors.hpp"
#include "folder_path.hpp"
#include "folder_plan.hpp"
#include "imu_table.hpp"
#include "scan_list.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr int kDepth = 2;                 ///< of folders below the one that is named
constexpr std::size_t kMaxTables = 1000;  ///< looked at for an IMU
constexpr std::size_t kMaxFolders = 1000;
constexpr std::size_t kMaxEntries = 4'000'000;  ///< of one folder

struct Contents {
  std::vector<fs::path> folders, tables;
  fs::path scan;  ///< one of the scans, or empty
};

Contents contents_of(const fs::path& folder) {
  Contents contents;
  std::error_code error;
  std::size_t entries = 0;
  for (fs::directory_iterator it(folder, error), end; !error && it != end && ++entries < kMaxEntries;
       it.increment(error)) {
    std::error_code ignored;
    const fs::path& path = it->path();
    const std::string extension = path.extension().string();
    if (it->is_directory(ignored)) {
      contents.folders.push_back(path);
    } else if (is_scan_file(path)) {
      if (contents.scan.empty() || path < contents.scan) contents.scan = path;
    } else if (extension == ".csv" || extension == ".txt") {
      contents.tables.push_back(path);
    }
  }
  std::sort(contents.folders.begin(), contents.folders.end());
  std::sort(contents.tables.begin(), contents.tables.end());
  return contents;
}

std::string name_below(const fs::path& path, const fs::path& root) {
  const fs::path relative = path.lexically_relative(root);
  return relative == "." ? named_folder(root).filename().string() : relative.generic_string();
}

class FolderSearch {
 public:
  FolderSearch(const fs::path& root, const SensorConfig& sensor) : root_(root), sensor_(sensor) {}

  FolderPlan find() {
    plan_.kind = "folder of scans";
    plan_.folder = root_;
    plan_.without_imu =
        "put a table (.csv, .txt) beside the scans whose first line names its columns, like "
        "`timestamp,wx,wy,wz,ax,ay,az`, "
        "or name those of a table with `imu` in its name in `imu_columns` of the sensor file";
    look_into(root_, kDepth);
    return std::move(plan_);
  }

 private:
  void look_into(const fs::path& folder, int depth) {
    if (++folders_ > kMaxFolders) return;
    const Contents contents = contents_of(folder);
    if (!contents.scan.empty()) add_lidar(folder, contents.scan);
    for (const fs::path& table : contents.tables) {
      if (++tables_ <= kMaxTables && is_imu(table)) {
        plan_.imus.push_back({name_below(table, root_), table, {}});
      }
    }
    for (const fs::path& below : contents.folders) {
      if (depth > 0) look_into(below, depth - 1);
    }
  }

  bool is_imu(const fs::path& table) const {
    if (is_imu_table(table)) return true;
    const bool named = table.filename().string().find("imu") != std::string::npos;
    return named && !sensor_.imu_columns.empty();
  }

  void add_lidar(const fs::path& folder, const fs::path& scan) {
    if (scan.extension() == ".bin" && sensor_.scan_columns.empty()) {
      std::error_code ignored;
      const std::uintmax_t bytes = fs::file_size(scan, ignored);
      throw DataError(fmt::format(
          "{}: a .bin file does not tell its columns; name them in `scan_columns` of the sensor file, like `x y z "
          "intensity time ring` (float32; others like `ring:u16`); its {} bytes are points of {} numbers of 4 bytes",
          scan.string(), bytes, divisors(bytes)));
    }
    plan_.lidars.push_back({name_below(folder, root_), folder, sensor_.scan_columns, kTimeMax, {}});
  }

  static std::string divisors(std::uintmax_t bytes) {
    std::string text;
    for (unsigned numbers = 3; numbers <= 10; ++numbers) {
      if (bytes % (4 * numbers) == 0) text += fmt::format("{}{}", text.empty() ? "" : " or ", numbers);
    }
    return text.empty() ? "no whole number up to 10" : text;
  }

  fs::path root_;
  const SensorConfig& sensor_;
  FolderPlan plan_;
  std::size_t folders_ = 0, tables_ = 0;
};

}  // namespace

std::optional<FolderPlan> plan_any_folder(const fs::path& path, const SensorConfig& sensor) {
  FolderPlan plan = FolderSearch(path, sensor).find();
  if (plan.lidars.empty()) return std::nullopt;
  return plan;
}

std::string holdings(const fs::path& path) {
  constexpr std::size_t kMaxNamed = 20;
  std::map<std::string, std::size_t> by_extension;
  std::vector<std::string> folders;
  std::error_code error;
  std::size_t entries = 0;
  for (fs::directory_iterator it(path, error), end; !error && it != end && ++entries < kMaxEntries;
       it.increment(error)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) {
      folders.push_back(it->path().filename().string() + "/");
    } else {
      const std::string extension = it->path().extension().string();
      ++by_extension[extension.empty() ? "files without extension" : extension];
    }
  }
  std::sort(folders.begin(), folders.end());
  std::vector<std::string> parts;
  for (const auto& [extension, count] : by_extension) parts.push_back(fmt::format("{} {}", count, extension));
  parts.insert(parts.end(), folders.begin(), folders.end());
  if (parts.empty()) return "nothing";
  const bool more = parts.size() > kMaxNamed;
  if (more) parts.resize(kMaxNamed);
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return more ? text + ", .." : text;
}

}  // namespace aslio::io
