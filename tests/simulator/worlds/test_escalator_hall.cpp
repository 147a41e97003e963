/// The station hall as it is shipped, whole and shortened.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("a station hall leaves the route free, stands on its ground and has no holes", "[worlds]") {
  const double scale = GENERATE(0.2, 0.5, 1.0);
  CAPTURE(scale);
  const auto [scene, route] = shipped("escalator_hall", scale);
  const World world = build_escalator_hall(scene.world.escalator_hall, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.2);  // a step
  CHECK(share_of_hits(world, caster, route) > 0.999);
  CHECK(world.mesh.triangles.size() < 600'000);
}

TEST_CASE("any seed of a station hall leaves the route free", "[worlds]") {
  const auto [scene, route] = shipped("escalator_hall", 1);
  EscalatorHallParams params = scene.world.escalator_hall;
  params.clutter = 3;
  params.columns = 3;
  for (params.seed = 100; params.seed < 106; ++params.seed) {
    CAPTURE(params.seed);
    CHECK(worst_clearance(build_escalator_hall(params, route, 1), route) >= 1 - 1e-6);
  }
}

TEST_CASE("the walk through a station hall rises to the upper floor and comes down again", "[worlds]") {
  const auto [scene, route] = shipped("escalator_hall", 1);
  const World world = build_escalator_hall(scene.world.escalator_hall, route, 1);
  int above = 0, below = 0, between = 0;
  for (double s = 0; s < route.length(); s += 0.1) {
    const Vec2 p = route.at(s).at;
    const double z = world.ground.height(p.x(), p.y());
    above += std::abs(z - 4.8) < 1e-6 ? 1 : 0;
    below += std::abs(z) < 1e-6 ? 1 : 0;
    between += z > 0.5 && z < 4.3 ? 1 : 0;
  }
  CHECK(above > 300);
  CHECK(below > 300);
  CHECK(between > 120);  // two flights of more than 6 m each
}

TEST_CASE("the seed of a station hall gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("escalator_hall", 1);
  EscalatorHallParams params = scene.world.escalator_hall;
  const World first = build_escalator_hall(params, route, 1);
  CHECK(same_bits(first.mesh, build_escalator_hall(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_escalator_hall(params, route, 1).mesh));
}

TEST_CASE("a station hall names the edge that does not fit its escalators", "[worlds]") {
  const auto [scene, route] = shipped("escalator_hall", 1);
  EscalatorHallParams params = scene.world.escalator_hall;
  using Catch::Matchers::Contains;
  params.height = 16;
  CHECK_THROWS_WITH(build_escalator_hall(params, route, 1), Contains("edge 2 is") && Contains("world.height"));
  params.height = 4.8;
  params.up_edge = 12;
  CHECK_THROWS_WITH(build_escalator_hall(params, route, 1), Contains("world.up_edge is 12") && Contains("9 edges"));
  params.up_edge = 4;
  CHECK_THROWS_AS(build_escalator_hall(params, route, 1), ConfigError);
  const Route bent({{0, 0}, {20, 0}, {20, 10}, {3, 14}});
  params.up_edge = 1;
  CHECK_THROWS_WITH(build_escalator_hall(params, bent, 1), Contains("route: edge 3 from (20.00, 10.00)"));
}
