#pragma once
/// Arithmetic shared by all window strategies: when has the stream arrived to a wanted end, and what becomes of an
/// interval with too few points, of a gap and of the end of the stream. (WIN-3)

#include <cstddef>
#include <optional>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

/// The next fresh interval a strategy would like.
struct TileRequest {
  TimeNs begin = 0;            ///< end of the previous window
  TimeNs shift = 0;            ///< wanted length [ns], > 0
  TimeNs limit = 0;            ///< length up to which an interval short of points may grow [ns], >= shift
  std::size_t min_points = 0;  ///< points within [min_range, max_range] wanted; 0: any number will do
  double min_range = 0;        ///< [m]
  double max_range = 0;        ///< [m]
};

/// The fresh interval (begin, end] as it can be cut.
struct Tile {
  TimeNs end = 0;
  bool extended = false;  ///< longer than wanted, for want of points
  bool partial = false;   ///< it spans a gap in the points, or the stream ended inside it
};

/// All points and IMU samples up to `t` have arrived, or the source has ended.
bool arrived(const StreamView& stream, TimeNs t);

/// The source has ended and no point is left after `t`.
bool exhausted(const StreamView& stream, TimeNs t);

/// Settles the end of the next fresh interval; nothing while the answer is not certain yet, or when no point is left.
/// - Too few points: the interval grows to the point that completes `min_points`, but not beyond `limit`.
/// - No point at all: the interval takes in the gap and `shift` of the points behind it, however long the gap.
/// - End of the source: the interval ends with the last point.
/// The answer depends on the times of the data alone, never on how they were packed into messages.
std::optional<Tile> settle(const StreamView& stream, const TileRequest& request);

}  // namespace aslio
