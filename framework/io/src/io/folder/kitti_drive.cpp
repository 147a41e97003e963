#include "kitti_drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <limits>
#include <numbers>

#include "../decode/decode.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"
#include "folder_path.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestScan = 256U << 20U;
constexpr std::size_t kMaxFrames = 1'000'000;

std::ifstream open(const fs::path& path) {
  if (!fs::is_directory(path)) require_input(path);  // reading a folder says so
  std::ifstream file(path, std::ios::binary);
  if (!file) throw DataError(fmt::format("{}: cannot open; the folder is no complete KITTI raw drive", path.string()));
  return file;
}

[[noreturn]] void bad_line(const fs::path& path, std::size_t line, std::string_view text, std::string_view expected) {
  throw DataError(fmt::format("{}:{}: '{}' is not {}", path.string(), line, text.substr(0, 60), expected));
}

bool digits(std::string_view text, std::size_t at, std::size_t count, int& to) {
  if (at + count > text.size()) return false;
  const auto [end, error] = std::from_chars(text.data() + at, text.data() + at + count, to);
  return error == std::errc{} && end == text.data() + at + count;
}

/// `2011-09-26 13:04:32.335337762` without a time zone.
std::optional<TimeNs> parse_time(std::string_view text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, fraction = 0;
  const bool shape = text.size() == 29 && text[4] == '-' && text[7] == '-' && text[10] == ' ' && text[13] == ':' &&
                     text[16] == ':' && text[19] == '.';
  if (!shape || !digits(text, 0, 4, year) || !digits(text, 5, 2, month) || !digits(text, 8, 2, day) ||
      !digits(text, 11, 2, hour) || !digits(text, 14, 2, minute) || !digits(text, 17, 2, second) ||
      !digits(text, 20, 9, fraction)) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  // What is farther away is a mistake, and no message can carry it.
  if (!date.ok() || year < 1970 || year > 2100) return std::nullopt;
  const TimeNs days = std::chrono::sys_days{date}.time_since_epoch().count();
  return ((days * 24 + hour) * 60 + minute) * 60 * kSecond + second * kSecond + fraction;
}

/// By the number of the frame. An empty line stands for a frame that was lost, so that later ones keep their number; at
/// the end of the list it stands for nothing.
std::vector<std::optional<TimeNs>> read_times(const fs::path& path) {
  std::ifstream file = open(path);
  std::vector<std::optional<TimeNs>> times;
  std::string line;
  while (std::getline(file, line) && times.size() < kMaxFrames) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const auto t = parse_time(line);
    if (!t && !line.empty()) bad_line(path, times.size() + 1, line, "a time like 2011-09-26 13:04:32.335337762");
    times.push_back(t);
  }
  while (!times.empty() && !times.back()) times.pop_back();
  return times;
}

/// All numbers of a text; empty when one of them is none.
std::vector<double> numbers(std::string_view text) {
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    while (at != end && (*at == ' ' || *at == '\n' || *at == '\r' || *at == '\t')) ++at;
    if (at == end) return values;
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{}) return {};
    values.push_back(value);
    at = next;
  }
}

std::string numbered(std::size_t index, const char* extension) { return fmt::format("{:010d}{}", index, extension); }

/// Frame `i` has no time in `list`.
[[noreturn]] void no_time(const fs::path& list, std::size_t i, const fs::path& data) {
  throw DataError(fmt::format(
      "{}:{}: the line is empty, which marks a lost frame, but there is {}; put its time there, or remove that file",
      list.string(), i + 1, data.string()));
}

void read_oxts(KittiDrive& drive) {
  constexpr std::size_t kAcc = 11, kGyro = 17, kColumns = 20;
  const fs::path list = drive.oxts / "timestamps.txt";
  const std::vector<std::optional<TimeNs>> times = read_times(list);
  std::string line;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const fs::path path = drive.oxts / "data" / numbered(i, ".txt");
    std::error_code ignored;
    if (!fs::exists(path, ignored)) {
      ++drive.missing_imu;
      continue;
    }
    if (!times[i]) no_time(list, i, path);
    std::ifstream file = open(path);
    std::getline(file, line);
    const std::vector<double> v = numbers(line);
    if (v.size() < kColumns) bad_line(path, 1, line, "a line of at least 20 numbers (OXTS packet)");
    drive.imu.push_back(
        {*times[i], Vec3(v[kGyro], v[kGyro + 1], v[kGyro + 2]), Vec3(v[kAcc], v[kAcc + 1], v[kAcc + 2])});
  }
}

/// Binary, or the text of an unsynchronised drive; empty where there is neither.
fs::path scan_path(const fs::path& folder, std::size_t i) {
  std::error_code ignored;
  for (const char* extension : {".bin", ".txt"}) {
    if (fs::path path = folder / numbered(i, extension); fs::exists(path, ignored)) return path;
  }
  return {};
}

void read_scan_list(const fs::path& folder, KittiDrive& drive) {
  const fs::path begin_list = folder / "timestamps_start.txt", end_list = folder / "timestamps_end.txt";
  const std::vector<std::optional<TimeNs>> begin = read_times(begin_list), end = read_times(end_list);
  if (begin.size() != end.size()) {
    throw DataError(fmt::format("{}: timestamps_start.txt has {} times, timestamps_end.txt {}", folder.string(),
                                begin.size(), end.size()));
  }
  for (std::size_t i = 0; i < begin.size(); ++i) {
    if (begin[i] && end[i] && *end[i] <= *begin[i]) {
      throw DataError(fmt::format("{}:{}: the scan ends before it begins", end_list.string(), i + 1));
    }
    const fs::path path = scan_path(folder / "data", i);
    if (path.empty()) {
      ++drive.missing_scans;
      continue;
    }
    if (!begin[i] || !end[i]) no_time(begin[i] ? end_list : begin_list, i, path);
    drive.scans.push_back({*begin[i], *end[i], path});
  }
}

std::optional<Pose> read_calibration(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return std::nullopt;
  std::ifstream file = open(path);
  Pose T_velo_imu;
  bool rotation = false, translation = false;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line) && number < 100; ++number) {
    if (!line.starts_with("R:") && !line.starts_with("T:")) continue;
    const bool is_rotation = line[0] == 'R';
    const std::vector<double> v = numbers(std::string_view(line).substr(2));
    if (v.size() != (is_rotation ? 9 : 3)) bad_line(path, number, line, is_rotation ? "9 numbers" : "3 numbers");
    for (std::size_t i = 0; i < v.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      (is_rotation ? T_velo_imu.R(k / 3, k % 3) : T_velo_imu.p[k]) = v[i];
    }
    (is_rotation ? rotation : translation) = true;
  }
  if (!rotation || !translation) throw DataError(fmt::format("{}: lacks the line 'R:' or 'T:'", path.string()));
  T_velo_imu.R = orthonormalised(T_velo_imu.R);
  return T_velo_imu.inverse();
}

/// Where the packets of a drive are: of the unsynchronised drive beside a synchronised one, or its own. Empty: nowhere.
fs::path oxts_of(const fs::path& drive) {
  constexpr std::string_view kSync = "_sync";
  std::error_code ignored;
  const fs::path folder = named_folder(drive);
  if (std::string name = folder.filename().string(); name.ends_with(kSync)) {
    name.replace(name.size() - kSync.size(), kSync.size(), "_extract");
    const fs::path beside = folder.parent_path() / name / "oxts";
    if (fs::exists(beside / "timestamps.txt", ignored) && fs::is_directory(beside / "data", ignored)) return beside;
  }
  return fs::is_directory(drive / "oxts", ignored) ? drive / "oxts" : fs::path{};
}

using RawPoint = std::array<float, 4>;  ///< x, y, z, reflectance

std::vector<char> read_whole(const fs::path& path) {
  std::ifstream file = open(path);  // a folder opens, too
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  if (error) {
    throw DataError(fmt::format("{}: cannot be read as a scan ({}); put the scan of that number there, or remove it",
                                path.string(), error.message()));
  }
  if (bytes > kLargestScan) throw DataError(fmt::format("{}: {} bytes are no scan", path.string(), bytes));
  std::vector<char> raw(static_cast<std::size_t>(bytes));
  if (!file.read(raw.data(), static_cast<std::streamsize>(raw.size()))) {
    throw DataError(fmt::format("{}: cannot read", path.string()));
  }
  return raw;
}

std::vector<RawPoint> binary_points(const std::vector<char>& raw, std::string& damage) {
  std::vector<RawPoint> points(raw.size() / sizeof(RawPoint));
  if (!points.empty()) std::memcpy(points.data(), raw.data(), points.size() * sizeof(RawPoint));
  if (raw.size() % sizeof(RawPoint) != 0) damage = "the file ends inside a point";
  return points;
}

std::vector<RawPoint> text_points(const fs::path& path, const std::vector<char>& raw) {
  std::vector<RawPoint> points;
  std::string_view left(raw.data(), raw.size());
  for (std::size_t number = 1; !left.empty(); ++number) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(left.size(), line.size() + 1));
    const std::vector<double> v = numbers(line);
    if (v.size() == 4) {
      points.push_back(
          {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(v[3])});
    } else if (line.find_first_not_of(" \t\r") != std::string_view::npos) {
      bad_line(path, number, line, "a line of four numbers (x y z reflectance)");
    }
  }
  return points;
}

bool is_drive(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path / "velodyne_points", ignored) && !oxts_of(path).empty();
}

void collect_drives(const fs::path& path, int depth, std::vector<fs::path>& found) {
  if (is_drive(path)) {
    found.push_back(path);
    return;
  }
  if (depth == 0) return;
  std::error_code ignored;
  std::vector<fs::path> children;
  for (fs::directory_iterator it(path, ignored), end; it != end; it.increment(ignored)) {
    if (it->is_directory(ignored)) children.push_back(it->path());
  }
  std::sort(children.begin(), children.end());
  for (const fs::path& child : children) collect_drives(child, depth - 1, found);
}

}  // namespace

std::optional<fs::path> find_kitti_drive(const fs::path& path) {
  std::vector<fs::path> found;
  collect_drives(path, 2, found);
  if (found.empty()) return std::nullopt;
  if (found.size() == 1) return found.front();
  std::string list;
  for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 20); ++i) list += "\n  " + found[i].string();
  throw DataError(fmt::format("{}: contains {} drives; name one of them:{}", path.string(), found.size(), list));
}

KittiDrive read_kitti_drive(const fs::path& folder) {
  KittiDrive drive;
  drive.folder = folder;
  read_scan_list(folder / "velodyne_points", drive);
  drive.oxts = oxts_of(folder);
  read_oxts(drive);
  drive.T_imu_velo = read_calibration(named_folder(folder).parent_path() / "calib_imu_to_velo.txt");
  if (!drive.T_imu_velo) drive.T_imu_velo = read_calibration(folder / "calib_imu_to_velo.txt");
  return drive;
}

void read_kitti_scan(const KittiScan& scan, PointTable& table) {
  table.columns = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"t", 16, 6}, {"ring", 20, 2}};
  table.point_step = 21;
  const std::vector<char> raw = read_whole(scan.file);
  const std::vector<RawPoint> points =
      scan.file.extension() == ".txt" ? text_points(scan.file, raw) : binary_points(raw, table.damage);
  table.bytes.resize(points.size() * table.point_step);
  const double turn = static_cast<double>(scan.end - scan.begin) / (2 * std::numbers::pi);
  constexpr double pi = std::numbers::pi;
  double last = 0;  // azimuth, counted from ahead [rad]
  std::uint8_t line = 0;
  std::uint8_t* to = table.bytes.data();
  for (const RawPoint& v : points) {
    std::memcpy(to, v.data(), sizeof(v));
    if (decode::is_return(v[0], v[1], v[2])) {
      const double azimuth = std::atan2(double{v[1]}, double{v[0]});
      constexpr double kLongest = std::numeric_limits<std::uint32_t>::max();
      const auto t = static_cast<std::uint32_t>(std::llround(std::min(turn * (pi - azimuth), kLongest)));
      std::memcpy(to + 16, &t, sizeof(t));
      // The file has laser after laser, the highest first, each from ahead over the left once round.
      const double from_ahead = azimuth < 0 ? azimuth + 2 * pi : azimuth;
      if (from_ahead < last - pi && line < std::numeric_limits<std::uint8_t>::max()) ++line;
      last = from_ahead;
      to[20] = line;
    }
    to += table.point_step;
  }
}

}  // namespace aslio::io
