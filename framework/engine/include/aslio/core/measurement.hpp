#pragma once
/// What a source yields and the stream takes.

#include <string>
#include <variant>
#include <vector>

#include "aslio/core/types.hpp"

namespace aslio {

/// One LiDAR message: all its points, each with its own time.
struct LidarPacket {
  TimeNs stamp = 0;                 ///< of the message header
  std::uint32_t sweep_id = 0;       ///< count of messages of this topic
  std::vector<TimedPoint> points;   ///< any order; finite, but otherwise as received
  std::size_t dropped_invalid = 0;  ///< points the decoder dropped: not finite, zero return, or tagged as noise
  std::size_t beyond_lines = 0;     ///< of those, the ones that only their line number speaks against
  std::uint8_t highest_line = 0;    ///< of these
};

using Measurement = std::variant<LidarPacket, ImuSample>;

}  // namespace aslio
