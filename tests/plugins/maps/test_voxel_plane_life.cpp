// Planes in voxels over random lives against the rules written down plainly: what the map leaves out, because it would
// change nothing, must change nothing. (eqs. MAP-1, MAP-4)
#include <catch2/catch.hpp>

#include "plugins/maps/map_fixture.hpp"
#include "plugins/maps/plain_voxel_planes.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Walls of two faces, some thinner than the map can tell, whole or of half a voxel, and clutter.
struct Scene {
  struct Wall {
    Vec3 centre = Vec3::Zero(), normal = Vec3::Zero(), first = Vec3::Zero(), second = Vec3::Zero();
    double half = 0, thickness = 0, noise = 0;
  };
  explicit Scene(std::uint64_t seed) : uniform(seed) {
    for (int i = 0; i < 12; ++i) {
      Wall wall;
      wall.normal = uniform.in_box(Vec3::Zero(), 1).normalized();
      wall.first = wall.normal.unitOrthogonal();
      wall.second = wall.normal.cross(wall.first);
      wall.centre = uniform.in_box(Vec3::Zero(), 1);
      wall.half = uniform(0.2, 1.0);
      wall.thickness = uniform(0.002, 0.2);
      wall.noise = i % 4 == 0 ? 0.1 : uniform(0.001, 0.015);
      walls.push_back(wall);
    }
  }
  /// What is seen of one wall from somewhere on one of its sides, or along it.
  std::vector<WorldPoint> look(int count) {
    const Wall& wall = walls[static_cast<std::size_t>(uniform(0, 11.999))];
    const double side = uniform(-1, 1) < 0 ? -1 : 1;
    const double away = uniform(0.05, 3), beside = uniform(-4, 4);
    const Vec3 eye = wall.centre + side * away * wall.normal + beside * wall.first;
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i) {
      const double along = uniform(-wall.half, wall.half), up = uniform(-wall.half, wall.half);
      const double out = 0.5 * side * wall.thickness + uniform(-wall.noise, wall.noise);
      const Vec3 p = wall.centre + along * wall.first + up * wall.second + out * wall.normal;
      points.push_back(at(p));
      if (i % 50 != 0) points.back().view = PackedDirection((p - eye).cast<float>());  // some are seen from nowhere
    }
    return points;
  }
  Uniform uniform;
  std::vector<Wall> walls;
};

}  // namespace

TEST_CASE("voxel_plane over random lives: the planes of the plain rules, to whomever looks from wherever") {
  const auto levels = GENERATE(1, 2, 3);
  const auto most = GENERATE(as<std::uint32_t>{}, 60, 400);  // 256 of them tell the side
  EveryMap fixture;
  std::size_t met = 0, missed = 0, refused = 0, offered = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(levels, most, seed);
    const auto map = fixture.make("{type: voxel_plane, voxel: 0.5, max_points: " + std::to_string(most) +
                                  ", thickness: 0.023, levels: " + std::to_string(levels) + "}");
    PlainVoxelPlanes plain({.levels = levels, .max_points = most});
    Scene scene(seed);
    for (std::uint32_t step = 1; step <= 300; ++step) {
      const auto points = scene.look(static_cast<int>(scene.uniform(1, 200)));
      const InsertCount count = map->insert(points, step);
      REQUIRE(count.inserted == plain.insert(points));
      offered += count.offered;
      refused += count.offered - count.inserted;
      if (step % 10 != 0) continue;
      MapQuery query;
      query.viewpoint = scene.uniform.in_box(Vec3::Zero(), 3);
      std::vector<Vec3> queries;
      for (const WorldPoint& point : points) queries.push_back(point.p_W);
      std::vector<Surface> found(queries.size());
      map->surfaces(queries, query, found);
      for (std::size_t i = 0; i < queries.size(); ++i) {
        const auto expected = plain.at(queries[i], *query.viewpoint);
        REQUIRE(found[i].valid == expected.has_value());
        ++(expected ? met : missed);
        if (!expected) continue;
        REQUIRE((found[i].anchor - expected->mean).norm() < 1e-6);
        REQUIRE((found[i].normal - expected->normal).norm() < 1e-6);
      }
    }
  }
  CHECK(met > 1000);
  CHECK(missed > 1000);
  CHECK(refused > offered / (most < 256 ? 5 : 100));  // for those there is the early way out
  CHECK(refused < offered);
}
