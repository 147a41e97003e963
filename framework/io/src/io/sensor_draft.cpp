#include <fmt/format.h>

#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/io/inspect.hpp"

namespace aslio::io {
namespace {

const TopicReport& only_one(const InputReport& report, TopicRole role, const char* name) {
  const TopicReport* found = nullptr;
  for (const TopicReport& topic : report.topics) {
    if (topic.role != role || !topic.problem.empty()) continue;
    if (found != nullptr) {
      throw DataError(
          fmt::format("{}: it has several {} topics, {} and {}: name one in a sensor file and give it by --sensor",
                      report.name, name, found->topic, topic.topic));
    }
    found = &topic;
  }
  if (found == nullptr) throw DataError(fmt::format("{}: it has no {} topic that can be used", report.name, name));
  return *found;
}

/// A topic as a YAML scalar.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string draft_sensor(const InputReport& report) {
  const TopicReport& lidar = only_one(report, TopicRole::lidar, "LiDAR");
  const TopicReport& imu = only_one(report, TopicRole::imu, "IMU");
  constexpr double kRounded = 1e-3;  // [s]
  const double period = std::max(kRounded, std::round(lidar.median_period / kRounded) * kRounded);
  return fmt::format(
      "schema: aslio/sensor/1\n"
      "# As found in {}. `aslio describe sensor` explains every key.\n"
      "lidar_topic: {}\n"
      "imu_topic: {}\n"
      "acc_unit: {}\n"
      "gyro_unit: {}\n"
      "sweep_period: {:.3f}  # s, between LiDAR messages\n"
      "scan_lines: {}\n"
      "# To be filled in: the data do not tell them. p_imu = rotation * p_lidar + translation.\n"
      "T_imu_lidar:\n"
      "  placeholder: true  # delete this line once the pose is right\n"
      "  translation: [0, 0, 0]  # m, origin of the LiDAR in the IMU frame\n"
      "  rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]  # row by row\n",
      std::filesystem::path(report.name).filename().string(), quoted(lidar.topic), quoted(imu.topic), imu.acc_unit,
      imu.gyro_unit, period, std::max(lidar.lines, 1));
}

}  // namespace aslio::io
