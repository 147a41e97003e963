#pragma once

#include <algorithm>

#include "aslio/io/source.hpp"

namespace aslio::io {

/// Offsets of points from their stamp beyond several sweeps are bit errors or wrapped counters.
inline TimeNs longest_offset(const SensorConfig& sensor) {
  return std::max(kSecond, to_ns(5.0 * sensor.model.sweep_period));
}

}  // namespace aslio::io
