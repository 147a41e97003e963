#include "maps/feature_maps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio::plugins {

namespace {

std::unique_ptr<Map> map_of_points(const config::Nested<Map>& nested, const char* key, const BuildContext& context) {
  auto map = nested.make(context);
  if (map->content() == MapContent::points) return map;
  throw ConfigError(
      fmt::format("map feature_maps: {}: '{}' holds surfaces: choose a map of points (voxel_hash, ikd_tree, ivox)", key,
                  nested.type()));
}

}  // namespace

void FeatureMaps::describe(config::Binder& b, Params& p) {
  b.stage("lines", p.lines, "the map of points that are classed as lines");
  b.stage("planes", p.planes, "the map of all other points");
}

FeatureMaps::FeatureMaps(const Params& params, const BuildContext& context)
    : lines_(map_of_points(params.lines, "lines", context)), planes_(map_of_points(params.planes, "planes", context)) {}

void FeatureMaps::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  (feature_class::kind(query.feature) == feature_class::line ? lines_ : planes_)->correspond(queries, query, out);
}

InsertCount FeatureMaps::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  own_lines_.clear();
  own_planes_.clear();
  for (const WorldPoint& point : points) {
    (feature_class::kind(point.feature) == feature_class::line ? own_lines_ : own_planes_).push_back(point);
  }
  const InsertCount lines = lines_->insert(own_lines_, stamp), planes = planes_->insert(own_planes_, stamp);
  return {lines.offered + planes.offered, lines.inserted + planes.inserted};
}

void FeatureMaps::trim(const Vec3& centre_W) {
  lines_->trim(centre_W);
  planes_->trim(centre_W);
}

void FeatureMaps::clear() {
  lines_->clear();
  planes_->clear();
}

std::size_t FeatureMaps::memory_bytes() const {
  return sizeof(*this) + lines_->memory_bytes() + planes_->memory_bytes() +
         (own_lines_.capacity() + own_planes_.capacity()) * sizeof(WorldPoint);
}

double FeatureMaps::radius() const { return std::max(lines_->radius(), planes_->radius()); }

void FeatureMaps::visit(const std::function<void(const Vec3&)>& visitor) const {
  lines_->visit(visitor);
  planes_->visit(visitor);
}

}  // namespace aslio::plugins
