/// The forest as it is shipped, whole and shortened.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("a forest leaves its path free, and the path is as smooth as roots let it be", "[worlds]") {
  const double scale = GENERATE(0.2, 0.5, 1.0);
  CAPTURE(scale);
  const auto [scene, route] = shipped("forest", scale);
  ForestParams params = scene.world.forest;
  const World world = build_forest(params, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  CHECK(worst_ground(world, Caster(world.mesh), route) < 0.04);
  CHECK(world.mesh.triangles.size() < 600'000);
  params.clutter = 0;
  const World bare = build_forest(params, route, scale);
  CHECK(worst_ground(bare, Caster(bare.mesh), route) < 0.015);
}

TEST_CASE("any seed of a forest leaves its path free", "[worlds]") {
  const auto [scene, route] = shipped("forest", 0.4);
  ForestParams params = scene.world.forest;
  params.trees = 15;
  params.lean = 15;
  params.bushes = 2;
  params.clutter = 2;
  params.relief = 8;
  for (params.seed = 100; params.seed < 103; ++params.seed) {
    CAPTURE(params.seed);
    CHECK(worst_clearance(build_forest(params, route, 0.4), route) >= 1 - 1e-6);
  }
}

TEST_CASE("the seed of a forest gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("forest", 0.4);
  ForestParams params = scene.world.forest;
  const World first = build_forest(params, route, 0.4);
  CHECK(same_bits(first.mesh, build_forest(params, route, 0.4).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_forest(params, route, 0.4).mesh));
}

TEST_CASE("in a forest neighbouring rays hardly ever lie on one plane, and some see the sky", "[worlds]") {
  const auto [scene, route] = shipped("forest", 1);
  const World world = build_forest(scene.world.forest, route, 1);
  const Caster caster(world.mesh);
  const double share = share_of_hits(world, caster, route);
  CHECK(share > 0.55);
  CHECK(share < 0.98);
  // Level and rising rays: the second difference of three ranges, one degree apart, on a plane is a few millimetres.
  int planes = 0, triples = 0;
  for (double s = 0; s < route.length(); s += 2) {
    const Vec2 p = route.at(s).at;
    const Vec3 eye(p.x(), p.y(), world.ground.height(p.x(), p.y()) + 1.4);
    for (int k = 0; k < 360; k += 3) {
      std::array<double, 3> inverse{};
      for (int j = 0; j < 3; ++j) {
        const double a = (k + j) * std::numbers::pi / 180;
        inverse.at(static_cast<std::size_t>(j)) = 1 / caster.cast(eye, {std::cos(a), std::sin(a), 0}, 60).range;
      }
      if (inverse[0] == 0 || inverse[1] == 0 || inverse[2] == 0) continue;
      ++triples;
      // On a plane the inverse range is a sinusoid of the angle.
      const double flat = inverse[0] + inverse[2] - 2 * std::cos(std::numbers::pi / 180) * inverse[1];
      planes += std::abs(flat) < 1e-4 * inverse[1] ? 1 : 0;
    }
  }
  CAPTURE(planes, triples);
  CHECK(triples > 2000);
  CHECK(planes < triples / 20);
}
