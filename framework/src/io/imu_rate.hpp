#pragma once

#include <span>

#include "aslio/io/source.hpp"

namespace aslio::io {

/// IMU data by which units and rate are judged; the norm of gravity is judged on the first second.
inline constexpr TimeNs kJudgedImuSpan = 5 * kSecond;
inline constexpr std::size_t kJudgedImuSamples = 20'000;  ///< at most

/// States the rate of the IMU, and what a slow one means.
void note_imu_rate(std::span<const ImuSample> samples, SourceNotes& notes);

}  // namespace aslio::io
