#include "insertions/cell_nearest.hpp"

#include <cmath>

#include "insertions/of_kind.hpp"

namespace aslio::plugins {

namespace {
/// Farther than this many cells from a point nothing can be nearer to the centre of its cell: twice sqrt(3)/2, and some
/// room for rounding.
constexpr double kReach = 1.7321;
}  // namespace

void InsertCellNearest::describe(config::Binder& b, Params& p) {
  b.real("cell", p.cell, "m", {.min = 0.01, .max = 100.0}, "edge of the cells");
  b.integer("k", p.k, "", {.min = 1, .max = Neighbours::kMax}, "nearest points of the map that are looked at");
}

bool InsertCellNearest::nearer_to_centre(std::size_t query) const {
  const Vec3& p = queries_[query];
  const Vec3 centre = params_.cell * ((p / params_.cell).array().floor() + 0.5).matrix();
  const Vec3 from_centre = p - centre;
  const double own = from_centre.squaredNorm();
  for (std::size_t j = 0; j < nearest_.count[query]; ++j) {
    if ((from_centre + nearest_.offset(query, j).cast<double>()).squaredNorm() < own) return true;
  }
  return false;
}

InsertCount InsertCellNearest::apply(const Window& window, const Update& update, Map& map) {
  return insert_by_kind(update.points(PointUse::map), own_, [&](std::span<const WorldPoint> points, std::uint8_t kind) {
    return insert(points, kind, window.sequence, map);
  });
}

std::size_t InsertCellNearest::insert(std::span<const WorldPoint> points, std::uint8_t kind, std::uint32_t stamp,
                                      Map& map) {
  if (queries_.capacity() < points.size()) {
    queries_.reserve(2 * points.size());
    chosen_.reserve(2 * points.size());
  }
  queries_.clear();
  for (const WorldPoint& point : points) queries_.push_back(point.p_W);
  const MapQuery query{.k = static_cast<int>(params_.k), .max_distance = kReach * params_.cell, .feature = kind};
  map.correspond(queries_, query, nearest_);
  chosen_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!nearer_to_centre(i)) chosen_.push_back(points[i]);
  }
  return map.insert(chosen_, stamp).inserted;
}

}  // namespace aslio::plugins
