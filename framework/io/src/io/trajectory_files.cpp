#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <charconv>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "reference/stamps.hpp"
#include "reference/text_rows.hpp"

namespace aslio::io {
namespace {

/// Shortest text that reads back to the same double.
std::string shortest(double value) { return fmt::format("{}", value); }

std::string seconds(TimeNs t) {
  // As integers: a double holds an epoch to 240 ns only.
  const auto magnitude = t < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  return fmt::format("{}{}.{:09d}", t < 0 ? "-" : "", magnitude / kSecond, magnitude % kSecond);
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

StampedPose tum_pose(const TextRows& row) {
  const auto& parts = row.cells();
  if (parts.size() != 8) {
    row.refuse(fmt::format("{} columns where TUM has 8 (t tx ty tz qx qy qz qw)", parts.size()),
               fmt::format("{}", fmt::join(parts, " ")));
  }
  StampedPose pose;
  const auto t = parse_time(parts[0], TimeUnit::s);
  if (!t) row.refuse(time_problem(parts[0]), parts[0]);
  pose.t = *t;
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < 7; ++i) {
    const auto value = parse_number(parts[i + 1]);
    if (!value) row.refuse("not a finite number", parts[i + 1]);
    v[i] = *value;
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  constexpr double kTolerance = 1e-2;
  if (std::abs(q.norm() - 1) > kTolerance) {
    row.refuse(fmt::format("a quaternion of norm {:.4f}", q.norm()), fmt::format("{}", fmt::join(parts, " ")));
  }
  pose.T = {q.normalized().toRotationMatrix(), Vec3(v[0], v[1], v[2])};
  return pose;
}

/// A stamp that is not later than the one before. Several equal ones were not written so: their digits were cut.
[[noreturn]] void refuse_order(TextRows& row, const std::vector<StampedPose>& poses) {
  constexpr std::size_t kFewest = 3;
  const std::string text = fmt::format("{}", fmt::join(row.cells(), " "));
  const std::size_t line = row.line();
  const TimeNs before = poses.back().t;
  std::size_t equal = 1;
  for (bool more = tum_pose(row).t == before; more; more = row.next() && tum_pose(row).t == before) ++equal;
  if (equal >= kFewest) {
    row.refuse_at(line,
                  fmt::format("{}{} stamps are equal: they were written with too few digits; write them anew with 6 "
                              "decimals of a second at least",
                              poses.size() == 1 ? "the first " : "", equal),
                  text);
  }
  row.refuse_at(line,
                fmt::format("its time is not later than {} s of the pose before: sort the poses and remove duplicates",
                            seconds(before)),
                text);
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
  const std::string text = read_whole(path.string());
  TextRows row(text, path.string());
  std::vector<StampedPose> poses;
  while (row.next()) {
    const StampedPose pose = tum_pose(row);
    if (!poses.empty() && pose.t <= poses.back().t) refuse_order(row, poses);
    poses.push_back(pose);
  }
  if (poses.empty()) throw DataError(fmt::format("{}: holds no pose: is it the right file?", path.string()));
  return poses;
}

}  // namespace aslio::io
