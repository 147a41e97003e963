// Planes in staggered grids against one grid that the world is moved under. (eq. MAP-5)
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

const std::string kPlanes = "voxel: 1, min_points: 10, max_points: 300, thickness: 0.03";

/// Walls in all directions and clutter, each seen from one side.
std::vector<WorldPoint> patches(Uniform& uniform, int count) {
  std::vector<WorldPoint> points;
  for (int k = 0; k < count; ++k) {
    const Vec3 centre = uniform.in_box(Vec3::Zero(), 4.0), normal = uniform.in_box(Vec3::Zero(), 1.0).normalized();
    const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
    const double thick = k % 5 == 0 ? 0.4 : 0.02;
    for (int i = 0; i < 150; ++i) {
      const double a = uniform(-0.8, 0.8), b = uniform(-0.8, 0.8), c = uniform(-thick, thick);
      WorldPoint point = at(centre + a * first + b * second + c * normal);
      point.view = PackedDirection((-normal + 0.2 * uniform.in_box(Vec3::Zero(), 1.0)).cast<float>());
      points.push_back(point);
    }
  }
  return points;
}

std::vector<WorldPoint> moved(std::vector<WorldPoint> points, double by) {
  for (WorldPoint& point : points) point.p_W += Vec3::Constant(by);
  return points;
}

std::vector<Surface> ask(const Map& map, const std::vector<Vec3>& queries, const MapQuery& how) {
  std::vector<Surface> found(queries.size());
  map.surfaces(queries, how, found);
  return found;
}

}  // namespace

TEST_CASE("staggered_planes: each query has the plane of its own grid, as if the world were moved under one grid") {
  EveryMap fixture;
  for (const std::size_t grids : {1U, 2U, 3U, 4U}) {
    const double parts = grids == 2 ? 3 : grids == 4 ? 5 : static_cast<double>(grids);
    CAPTURE(grids);
    Uniform uniform(grids);
    const auto map = fixture.make("{type: staggered_planes, grids: " + std::to_string(grids) + ", " + kPlanes + "}");
    std::vector<std::unique_ptr<Map>> each;
    for (std::size_t g = 0; g < grids; ++g) each.push_back(fixture.make("{type: voxel_plane, " + kPlanes + "}"));
    std::vector<Vec3> queries;
    for (std::uint32_t stamp = 1; stamp <= 6; ++stamp) {
      const auto points = patches(uniform, 30);
      const InsertCount count = map->insert(points, stamp);
      std::size_t most = 0;
      for (std::size_t g = 0; g < grids; ++g) {
        const double by = static_cast<double>(g) / parts;
        most = std::max(most, each[g]->insert(moved(points, by), stamp).inserted);
      }
      CHECK(count.offered == points.size());
      CHECK(count.inserted == most);
      for (std::size_t i = 0; i < points.size(); i += 7) queries.push_back(points[i].p_W);
    }
    MapQuery how;
    how.max_stamp = 5;
    how.viewpoint = Vec3(1, -2, 0.5);
    const auto found = ask(*map, queries, how);
    std::size_t planes = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const Vec3 by = Vec3::Constant(static_cast<double>(i % grids) / parts);
      MapQuery there = how;
      there.viewpoint = *how.viewpoint + by;
      const Surface expected = ask(*each[i % grids], {queries[i] + by}, there)[0];
      REQUIRE(found[i].valid == expected.valid);
      if (!expected.valid) continue;
      ++planes;
      CHECK((found[i].normal - expected.normal).norm() < 1e-6);
      CHECK((found[i].anchor + by - expected.anchor).norm() < 1e-6);
      CHECK(found[i].quality == Approx(expected.quality).epsilon(1e-5));
    }
    CHECK(planes > 500);
    std::size_t bytes = 0;
    for (const auto& one : each) bytes += one->memory_bytes();
    CHECK(map->size() == each[0]->size());
    CHECK(map->memory_bytes() == bytes);
  }
}

TEST_CASE("staggered_planes: neighbours on a wall meet planes of different grids, each of which is known by itself") {
  EveryMap fixture;
  const auto map = fixture.make("{type: staggered_planes, grids: 3, voxel: 1}");
  Uniform uniform(4);
  std::vector<WorldPoint> wall;
  for (int i = 0; i < 20000; ++i) wall.push_back(at({uniform(-3, 3), uniform(-3, 3), 0.11 + uniform(-0.01, 0.01)}));
  map->insert(wall, 1);
  const auto found = ask(*map, std::vector<Vec3>(9, Vec3(0.2, 0.3, 0.11)), {});
  std::set<const void*> owners;
  for (const Surface& surface : found) {
    REQUIRE(surface.valid);
    owners.insert(surface.owner);
  }
  CHECK(owners.size() == 3);
  for (std::size_t i = 3; i < found.size(); ++i) CHECK(found[i].owner == found[i - 3].owner);
}

TEST_CASE("staggered_planes: fewer queries than grids, and none") {
  EveryMap fixture;
  const auto map = fixture.make("{type: staggered_planes, grids: 8, voxel: 1}");
  Uniform uniform(5);
  std::vector<WorldPoint> wall;
  for (int i = 0; i < 20000; ++i) wall.push_back(at({uniform(-3, 3), uniform(-3, 3), 0.11}));
  map->insert(wall, 1);
  CHECK(ask(*map, {}, {}).empty());
  for (const Surface& surface : ask(*map, std::vector<Vec3>(3, Vec3(0.2, 0.3, 0.11)), {})) CHECK(surface.valid);
}
