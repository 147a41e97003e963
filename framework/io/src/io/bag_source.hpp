#pragma once

#include <memory>

#include "aslio/io/source.hpp"

namespace aslio::io {

std::unique_ptr<MeasurementSource> open_bag(const std::filesystem::path& path, const SensorConfig& sensor,
                                            const Section& section);

}  // namespace aslio::io
