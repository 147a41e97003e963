#pragma once
/// Sensor files as commands read them.

#include <filesystem>

#include "aslio/config/load.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io {

/// Reads a sensor file as config::load() does, and throws as that does. An extrinsic that is marked as a placeholder is
/// used, and `placeholder_warning` of the value says so: the sources that open_source() opens, and inspect(), repeat
/// it.
config::Loaded<SensorConfig> load_sensor(const std::filesystem::path& file, const config::StageLookup& stages);

}  // namespace aslio::io
