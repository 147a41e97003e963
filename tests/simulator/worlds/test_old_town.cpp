/// The old town as it is shipped, whole and shortened.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <set>

#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("an old town leaves the route free and stands on its ground", "[worlds]") {
  const double scale = GENERATE(0.2, 0.5, 1.0);
  CAPTURE(scale);
  const auto [scene, route] = shipped("old_town", scale);
  OldTownParams params = scene.world.old_town;
  const World world = build_old_town(params, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  CHECK(worst_ground(world, Caster(world.mesh), route) < 0.15);  // a step
  CHECK(world.mesh.triangles.size() < 600'000);
  params.steps = 0;
  const World level = build_old_town(params, route, scale);
  CHECK(worst_ground(level, Caster(level.mesh), route) < 0.01);
}

TEST_CASE("any seed of an old town leaves the route free", "[worlds]") {
  const auto [scene, route] = shipped("old_town", 1);
  OldTownParams params = scene.world.old_town;
  params.alley = 2.6;
  params.skew = 15;
  params.curved = 1;
  params.arcades = 0.5;
  params.passages = 8;
  for (params.seed = 100; params.seed < 105; ++params.seed) {
    CAPTURE(params.seed);
    const World world = build_old_town(params, route, 1);
    CHECK(worst_clearance(world, route) >= 1 - 1e-6);
    CHECK(worst_ground(world, Caster(world.mesh), route) < 0.15);
  }
}

TEST_CASE("the seed of an old town gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("old_town", 1);
  OldTownParams params = scene.world.old_town;
  const World first = build_old_town(params, route, 1);
  CHECK(same_bits(first.mesh, build_old_town(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_old_town(params, route, 1).mesh));
}

TEST_CASE("the walls of an old town face every direction, and its sky is open but for its vaults", "[worlds]") {
  const auto [scene, route] = shipped("old_town", 1);
  const World world = build_old_town(scene.world.old_town, route, 1);
  // Upright triangles of at least a hand's breadth, by the direction of their normals in steps of 5 degrees.
  std::set<int> directions;
  for (const Mesh::Triangle& t : world.mesh.triangles) {
    const auto& v = world.mesh.vertices;
    const Eigen::Vector3f normal = (v[t.b] - v[t.a]).cross(v[t.c] - v[t.a]);
    if (normal.norm() < 0.02F || std::abs(normal.z()) > 0.01F * normal.norm()) continue;
    directions.insert(static_cast<int>(std::floor(std::atan2(normal.y(), normal.x()) * 36 / std::numbers::pi)));
  }
  CHECK(directions.size() >= 70);
  const Caster caster(world.mesh);
  int covered = 0, places = 0;
  for (double s = 0; s < route.length(); s += 0.5, ++places) {
    const Vec2 p = route.at(s).at;
    const double range = caster.cast({p.x(), p.y(), world.ground.height(p.x(), p.y()) + 1}, Vec3::UnitZ(), 50).range;
    covered += std::isfinite(range) ? 1 : 0;
    if (std::isfinite(range)) CHECK(range > 2.2);
  }
  CHECK(covered > 8);
  CHECK(covered < places / 3);
}
