#pragma once

#include <cmath>

#include "aslio/core/measurement.hpp"
#include "fuzz/target.hpp"

namespace aslio::fuzz {

/// What decoders let through: finite, not the zero return, within 100 km.
inline void must_be_returns(const LidarPacket& packet) {
  for (const TimedPoint& p : packet.points) {
    const bool near = std::abs(p.x) < 1e5F && std::abs(p.y) < 1e5F && std::abs(p.z) < 1e5F;
    must(near && (p.x != 0 || p.y != 0 || p.z != 0), "a point is a return");
  }
}

}  // namespace aslio::fuzz
