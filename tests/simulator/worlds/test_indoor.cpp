/// The office as it is shipped, whole and shortened.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("an office leaves the route free, stands on its ground and has no holes", "[worlds]") {
  const std::string name = GENERATE("indoor_1", "quickstart");
  const double scale = GENERATE(0.2, 0.5, 1.0, 2.0);
  CAPTURE(name, scale);
  const auto [scene, route] = shipped(name, scale);
  const OfficeParams& params = scene.world.office;
  const World world = build_office(params, route, scale);
  CHECK(worst_clearance(world, route, office_doors(params, route, scale)) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(share_of_hits(world, caster, route) > 0.999);
}

TEST_CASE("the seed of an office gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("indoor_1", 1);
  OfficeParams params = scene.world.office;
  const World first = build_office(params, route, 1);
  CHECK(same_bits(first.mesh, build_office(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_office(params, route, 1).mesh));
}

TEST_CASE("any seed of an office leaves the route free", "[worlds]") {
  const std::string name = GENERATE("indoor_1", "quickstart");
  const auto [scene, route] = shipped(name, 1);
  OfficeParams params = scene.world.office;
  params.clutter = 3;
  for (params.seed = 100; params.seed < 110; ++params.seed) {
    CAPTURE(name, params.seed);
    const World world = build_office(params, route, 1);
    CHECK(worst_clearance(world, route, office_doors(params, route, 1)) >= 1 - 1e-6);
    const Caster caster(world.mesh);
    CHECK(share_of_hits(world, caster, route) > 0.999);
  }
}

TEST_CASE("an office has things to see: corridors, rooms behind open doors, clutter on the walls", "[worlds]") {
  const auto [scene, route] = shipped("indoor_1", 1);
  OfficeParams params = scene.world.office;
  const std::size_t usual = build_office(params, route, 1).mesh.triangles.size();
  params.clutter = 0;
  const std::size_t bare = build_office(params, route, 1).mesh.triangles.size();
  params.room_density = 0;
  const std::size_t plain = build_office(params, route, 1).mesh.triangles.size();
  CHECK(usual > bare + 2000);
  CHECK(bare > plain + 2000);
}

TEST_CASE("the rooms of an office have their doors on the route", "[worlds]") {
  const auto [scene, route] = shipped("quickstart", 1);
  const std::vector<Vec2> doors = office_doors(scene.world.office, route, 1);
  REQUIRE(doors.size() == 2);
  for (const Vec2& door : doors) CHECK(route.distance(door) < 1e-9);
  CHECK((doors[0] - doors[1]).norm() > 3);
}

TEST_CASE("an office asks for edges parallel to the axes and names the one that is not", "[worlds]") {
  const Route route({{0, 0}, {10, 0}, {10, 8}, {1, 7}});
  CHECK_THROWS_WITH(build_office({}, route, 1), Catch::Matchers::Contains("edge 2 from (10.00, 8.00) to (1.00, 7.00)"));
  CHECK_THROWS_AS(build_office({}, route, 1), ConfigError);
}
