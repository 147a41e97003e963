#pragma once

#include <memory>

#include "aslio/io/source.hpp"

namespace aslio::io {

/// `folder` as found by find_kitti_drive().
std::unique_ptr<MeasurementSource> open_kitti(const std::filesystem::path& folder, const SensorConfig& sensor,
                                              const Section& section);

}  // namespace aslio::io
