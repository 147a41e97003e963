/// The library as it is shipped, whole and shortened.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("a library leaves the route free, stands on its ground and has no holes", "[worlds]") {
  const double scale = GENERATE(0.2, 0.5, 1.0);
  CAPTURE(scale);
  const auto [scene, route] = shipped("indoor_3", scale);
  const World world = build_library(scene.world.library, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(share_of_hits(world, caster, route) > 0.999);
  CHECK(world.mesh.triangles.size() < 1'500'000);
}

TEST_CASE("the seed of a library gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("indoor_3", 1);
  LibraryParams params = scene.world.library;
  const World first = build_library(params, route, 1);
  CHECK(same_bits(first.mesh, build_library(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_library(params, route, 1).mesh));
}

TEST_CASE("any seed of a library leaves the route free", "[worlds]") {
  const auto [scene, route] = shipped("indoor_3", 1);
  LibraryParams params = scene.world.library;
  for (params.seed = 100; params.seed < 103; ++params.seed) {
    CAPTURE(params.seed);
    CHECK(worst_clearance(build_library(params, route, 1), route) >= 1 - 1e-6);
  }
}

TEST_CASE("the aisles of a library are narrow and hide most of the view", "[worlds]") {
  const auto [scene, route] = shipped("indoor_3", 1);
  const World world = build_library(scene.world.library, route, 1);
  const Caster caster(world.mesh);
  int narrow = 0, places = 0;
  for (double s = 0; s < route.length(); s += 0.25) {
    const auto [at, direction] = route.at(s);
    const Vec3 eye(at.x(), at.y(), 1.4), left(-direction.y(), direction.x(), 0);
    const double reach = caster.cast(eye, left, 100).range + caster.cast(eye, -left, 100).range;
    ++places;
    narrow += reach > 1.2 && reach < 1.5 + 2 * 0.3 ? 1 : 0;  // a shelf is 0.3 m deep
  }
  CHECK(narrow > 0.6 * places);
}

TEST_CASE("a library asks for edges parallel to the axes and names the one that is not", "[worlds]") {
  const Route route({{0, 0}, {10, 0}, {10, 8}, {1, 7}});
  CHECK_THROWS_WITH(build_library({}, route, 1),
                    Catch::Matchers::Contains("edge 2 from (10.00, 8.00) to (1.00, 7.00)"));
}
