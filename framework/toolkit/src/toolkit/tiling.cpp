#include "aslio/toolkit/tiling.hpp"

#include <algorithm>

namespace aslio {

namespace {

/// Time of the point that completes the wanted number, among `points`.
std::optional<TimeNs> completed_at(std::span<const TimedPoint> points, const TileRequest& request) {
  const double min_squared = request.min_range * request.min_range;
  const double max_squared = request.max_range * request.max_range;
  std::size_t count = 0;
  for (const TimedPoint& p : points) {
    const double squared =
        static_cast<double>(p.x) * p.x + static_cast<double>(p.y) * p.y + static_cast<double>(p.z) * p.z;
    if (squared >= min_squared && squared <= max_squared && ++count == request.min_points) return p.t;
  }
  return std::nullopt;
}

/// End of the interval as far as the points decide it, when the interval holds at least one.
std::optional<Tile> settle_points(const StreamView& stream, const TileRequest& request) {
  const TimeNs until = stream.points_until();
  Tile tile{.end = request.begin + request.shift};
  if (until < tile.end) return std::nullopt;
  if (request.min_points == 0 || request.limit <= request.shift) return tile;
  const TimeNs farthest = request.begin + request.limit;
  const auto complete = completed_at(stream.points(request.begin, std::min(farthest, until)), request);
  if (!complete && until < farthest) return std::nullopt;
  const TimeNs wanted = tile.end;
  tile.end = std::max(wanted, complete.value_or(farthest));
  tile.extended = tile.end > wanted;
  return tile;
}

}  // namespace

bool arrived(const StreamView& stream, TimeNs t) { return stream.points_until() >= t && stream.imu_until() >= t; }

bool exhausted(const StreamView& stream, TimeNs t) {
  return stream.points_until() == kTimeMax && stream.last_point() <= t;
}

std::optional<Tile> settle(const StreamView& stream, const TileRequest& request) {
  if (exhausted(stream, request.begin)) return std::nullopt;
  auto tile = settle_points(stream, request);
  if (tile && stream.points(request.begin, tile->end).empty()) {
    const auto after = stream.points(request.begin, stream.points_until());
    if (after.empty()) return std::nullopt;
    TileRequest behind_gap = request;
    behind_gap.begin = after.front().t - 1;
    tile = settle_points(stream, behind_gap);
    if (tile) tile->partial = true;
  }
  if (!tile) return std::nullopt;
  if (stream.points_until() == kTimeMax && tile->end > stream.last_point()) {
    *tile = {.end = stream.last_point(), .extended = false, .partial = true};
  }
  if (stream.imu_until() < tile->end) return std::nullopt;
  return tile;
}

}  // namespace aslio
