#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io {
namespace {

/// Shortest text that reads back to the same double.
std::string shortest(double value) { return fmt::format("{}", value); }

std::string seconds(TimeNs t) {
  // As integers: a double holds an epoch to 240 ns only.
  const auto magnitude = t < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  return fmt::format("{}{}.{:09d}", t < 0 ? "-" : "", magnitude / kSecond, magnitude % kSecond);
}

[[noreturn]] void bad(const std::filesystem::path& path, std::size_t line, std::string_view text,
                      std::string_view why) {
  throw DataError(fmt::format("{}:{}: {}: '{}'", path.string(), line, why, text.substr(0, 100)));
}

/// Decimal seconds to ns without passing through a double; exponents (numpy's %.18e) are accepted by way of one.
bool parse_seconds(std::string_view text, TimeNs& t) {
  if (text.find_first_of("eE") != std::string_view::npos) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !(std::abs(value) < 9e9)) return false;
    t = to_ns(value);
    return is_time(t);
  }
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t dot = text.find('.');
  const std::string_view whole = text.substr(0, dot);
  std::string fraction(dot == std::string_view::npos ? std::string_view{} : text.substr(dot + 1));
  if (fraction.find_first_not_of("0123456789") != std::string::npos) return false;
  const bool round_up = fraction.size() > 9 && fraction[9] >= '5';
  fraction.resize(9, '0');
  std::int64_t s = 0, ns = 0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), s);
  if (error != std::errc{} || end != whole.data() + whole.size() || s < 0 || s > kFarthestTime / kSecond) return false;
  std::from_chars(fraction.data(), fraction.data() + 9, ns);
  t = s * kSecond + ns + (round_up ? 1 : 0);
  if (negative) t = -t;
  return is_time(t);
}

/// Why a time was refused: whole numbers far beyond seconds are stamps in another unit.
std::string time_problem(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && value > 9'000'000'000) {
    const char* unit = value > 100'000'000'000'000'000 ? "nanoseconds: divide the stamps by 1e9"
                       : value > 100'000'000'000'000   ? "microseconds: divide the stamps by 1e6"
                                                       : "milliseconds: divide the stamps by 1e3";
    return fmt::format("not a time in seconds, but as it seems in {}", unit);
  }
  return "not a time in seconds";
}

std::vector<std::string_view> columns(std::string_view line) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return parts;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    parts.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

StampedPose parse_tum_line(const std::filesystem::path& path, std::size_t line, std::string_view text) {
  const auto parts = columns(text);
  if (parts.size() != 8)
    bad(path, line, text, fmt::format("{} columns where TUM has 8 (t tx ty tz qx qy qz qw)", parts.size()));
  StampedPose pose;
  if (!parse_seconds(parts[0], pose.t)) bad(path, line, parts[0], time_problem(parts[0]));
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < 7; ++i) {
    const std::string_view part = parts[i + 1];
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), v[i]);
    if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(v[i])) {
      bad(path, line, part, "not a finite number");
    }
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  constexpr double kTolerance = 1e-2;
  if (std::abs(q.norm() - 1) > kTolerance) bad(path, line, text, fmt::format("a quaternion of norm {:.4f}", q.norm()));
  pose.T = {q.normalized().toRotationMatrix(), Vec3(v[0], v[1], v[2])};
  return pose;
}

}  // namespace

std::string tum_line(const StampedPose& pose) {
  Eigen::Quaterniond q(pose.T.R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  std::string line = seconds(pose.t);
  for (const double v : {pose.T.p.x(), pose.T.p.y(), pose.T.p.z(), q.x(), q.y(), q.z(), q.w()})
    line += ' ' + shortest(v);
  return line + '\n';
}

std::string kitti_line(const Pose& pose) {
  std::string line;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) line += shortest(pose.R(row, column)) + ' ';
    line += shortest(pose.p[row]) + (row < 2 ? ' ' : '\n');
  }
  return line;
}

void write_tum(const std::filesystem::path& path, std::span<const StampedPose> poses) {
  AtomicFile file(path);
  for (const StampedPose& pose : poses) file.write(tum_line(pose));
  file.close();
}

void write_kitti(const std::filesystem::path& path, std::span<const StampedPose> poses) {
  AtomicFile file(path);
  for (const StampedPose& pose : poses) file.write(kitti_line(pose.T));
  file.close();
}

std::vector<StampedPose> read_tum(const std::filesystem::path& path) {
  require_input(path);
  std::ifstream file(path);
  if (!file) throw DataError(fmt::format("{}: cannot open the trajectory", path.string()));
  std::vector<StampedPose> poses;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const StampedPose pose = parse_tum_line(path, number, line);
    if (!poses.empty() && pose.t <= poses.back().t) {
      bad(path, number, line,
          fmt::format("its time is not later than {} s of the pose before: sort the poses and remove duplicates",
                      seconds(poses.back().t)));
    }
    poses.push_back(pose);
  }
  if (file.bad()) throw DataError(fmt::format("{}: cannot read", path.string()));
  if (poses.empty()) throw DataError(fmt::format("{}: holds no pose: is it the right file?", path.string()));
  return poses;
}

}  // namespace aslio::io
