#pragma once

#include <span>

#include "aslio/io/source.hpp"

namespace aslio::io {

/// States the rate of the IMU, and what a slow one means.
void note_imu_rate(std::span<const ImuSample> samples, SourceNotes& notes);

}  // namespace aslio::io
