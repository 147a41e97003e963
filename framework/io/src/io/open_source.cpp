#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "kitti_drive.hpp"
#include "kitti_source.hpp"
#include "recording_source.hpp"

namespace aslio::io {

std::unique_ptr<MeasurementSource> open_source(const std::filesystem::path& path, const SensorConfig& sensor,
                                               const Section& section) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw DataError(fmt::format("{}: no such file or folder", path.string()));
  if (section.start < 0 || (section.duration && *section.duration <= 0)) {
    throw ConfigError(fmt::format("a section starts at 0 s or later and lasts longer than 0 s, not {} s for {} s",
                                  section.start, section.duration.value_or(0)));
  }
  if (std::filesystem::is_directory(path, ignored)) {
    const auto drive = find_kitti_drive(path);
    if (!drive) {
      throw DataError(
          fmt::format("{}: this folder holds no KITTI raw drive (velodyne_points/ and oxts/); name a bag, or a "
                      "drive folder",
                      path.string()));
    }
    return open_kitti(*drive, sensor, section);
  }
  return open_recording(path.string(), open_messages(path), sensor, section);
}

}  // namespace aslio::io
