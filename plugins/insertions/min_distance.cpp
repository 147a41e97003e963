#include "insertions/min_distance.hpp"

#include "insertions/of_kind.hpp"

namespace aslio::plugins {

void InsertMinDistance::describe(config::Binder& b, Params& p) {
  b.real("distance", p.distance, "m", {.min = 0.001, .max = 100.0},
         "a point nearer than this to one of the map does not enter");
}

InsertCount InsertMinDistance::apply(const Window& window, const Update& update, Map& map) {
  return insert_by_kind(update.points(PointUse::map), own_, [&](std::span<const WorldPoint> points, std::uint8_t kind) {
    return insert(points, kind, window.sequence, map);
  });
}

std::size_t InsertMinDistance::insert(std::span<const WorldPoint> points, std::uint8_t kind, std::uint32_t stamp,
                                      Map& map) {
  if (queries_.capacity() < points.size()) queries_.reserve(2 * points.size());
  queries_.clear();
  for (const WorldPoint& point : points) queries_.push_back(point.p_W);
  map.correspond(queries_, {.k = 1, .max_distance = distance_, .feature = kind}, nearest_);
  spaced_.begin(points.size());
  const auto too_near = static_cast<float>(distance_ * distance_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (nearest_.count[i] == 0 || nearest_.squared[i] >= too_near) spaced_.offer(points[i]);
  }
  return map.insert(spaced_.taken(), stamp).inserted;
}

}  // namespace aslio::plugins
