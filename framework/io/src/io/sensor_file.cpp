#include "aslio/io/sensor_file.hpp"

#include <fmt/format.h>

#include "aslio/config/node.hpp"

namespace aslio::io {

namespace {

/// A part of T_imu_lidar as it counts: that of the identity where the file leaves it out.
std::string written(const config::Node& pose, const char* key, const char* identity) {
  const config::Member* member = pose.find(key);
  return member != nullptr ? config::to_line(member->value) : identity;
}

}  // namespace

config::Loaded<SensorConfig> load_sensor(const std::filesystem::path& file, const config::StageLookup& stages) {
  auto loaded = config::load<SensorConfig>(file, config::FileKind::sensor, stages);
  if (!loaded.value.extrinsic_placeholder) return loaded;
  const config::Node& pose = loaded.tree.find("T_imu_lidar")->value;
  loaded.value.placeholder_warning = fmt::format(
      "{}: T_imu_lidar is still a placeholder, translation {} m and rotation {}, and is used as it stands: replace "
      "both by the pose of the LiDAR in the IMU frame, and delete this line; where they are right, delete the line "
      "alone (docs/howto_check_frames.md shows how to check them)",
      config::place_of(loaded.tree, "T_imu_lidar.placeholder").text(), written(pose, "translation", "[0, 0, 0]"),
      written(pose, "rotation", "[1, 0, 0, 0, 1, 0, 0, 0, 1]"));
  return loaded;
}

}  // namespace aslio::io
