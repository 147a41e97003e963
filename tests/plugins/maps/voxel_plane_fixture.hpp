#pragma once
/// What the tests of voxel_plane share.

#include "plugins/maps/map_fixture.hpp"

namespace aslio::test {

struct Planes {
  explicit Planes(const std::string& text, double voxel = 1.0)
      : corner(-voxel * Vec3(0.137, 0.223, 0.311)), map(fixture.make(text)) {}
  /// Points of z = height over [low, high] x [0, 1], from the corner of a voxel.
  std::size_t floor(double low, double high, double height, int count, std::uint32_t stamp = 1, double noise = 0.0) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      const double x = uniform(low, high), y = uniform(0, 1);
      points.push_back(at(corner + Vec3(x, y, height + uniform(-noise, noise))));
    }
    return map->insert(points, stamp).inserted;
  }
  Surface at_point(const Vec3& p, std::uint32_t max_stamp = 0xffffffff) {
    MapQuery query;
    query.max_stamp = max_stamp;
    std::vector<Surface> found(1);
    map->surfaces(std::vector<Vec3>{corner + p}, query, found);
    found[0].anchor -= corner;
    return found[0];
  }
  Vec3 corner;
  EveryMap fixture;
  Uniform uniform{1};
  std::unique_ptr<Map> map;
};

}  // namespace aslio::test
