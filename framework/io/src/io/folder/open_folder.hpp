#pragma once
/// Opens folders of files by what they hold.

#include <filesystem>
#include <memory>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io {

/// The recording that a folder holds. Throws DataError: what it holds and what is expected, where it is of no known
/// kind; or what is wrong with a file.
std::unique_ptr<MessageReader> open_folder(const std::filesystem::path& path, const SensorConfig& sensor);

/// The same as measurements. The topics of the sensor file are those of a bag: where the folder has one LiDAR, or one
/// IMU, they do not matter.
std::unique_ptr<MeasurementSource> open_folder_source(const std::filesystem::path& path, const SensorConfig& sensor,
                                                      const Section& section);

}  // namespace aslio::io
