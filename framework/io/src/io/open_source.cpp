#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "folder/open_folder.hpp"
#include "packets/open_packets.hpp"
#include "recording_files.hpp"
#include "recording_source.hpp"

namespace aslio::io {

namespace {

void check(const std::filesystem::path& path) {
  if (!is_input(path)) throw DataError(fmt::format("{}: no such file or folder", path.string()));
}

void check(const Section& section) {
  if (section.start >= 0 && (!section.duration || *section.duration > 0)) return;
  throw ConfigError(fmt::format("a section starts at 0 s or later and lasts longer than 0 s, not {} s for {} s",
                                section.start, section.duration.value_or(0)));
}

}  // namespace

bool is_input(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) || path.string().find_first_of("*?[") != std::string::npos;
}

std::unique_ptr<MeasurementSource> open_source(const std::filesystem::path& path, const SensorConfig& sensor,
                                               const Section& section) {
  check(path);
  check(section);
  if (is_folder_of_scans(path)) return open_folder_source(path, sensor, section);
  return open_recording(path.string(), packets::open_with_packets({&path, 1}, sensor), sensor, section);
}

std::unique_ptr<MeasurementSource> open_source(const std::vector<std::filesystem::path>& inputs,
                                               const SensorConfig& sensor, const Section& section) {
  if (inputs.size() == 1) return open_source(inputs.front(), sensor, section);
  check(section);
  std::string name;
  for (const auto& input : inputs) {
    check(input);
    name += (name.empty() ? "" : ", ") + input.string();
  }
  return open_recording(std::move(name), packets::open_with_packets(inputs, sensor), sensor, section);
}

}  // namespace aslio::io
