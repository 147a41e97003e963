/// Rooms joined by doorways as they are shipped, whole and shortened.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

namespace {

/// The frames of narrow doors come within 0.6 m a little earlier than those of an office.
constexpr double kDoorReach = 0.6;

}  // namespace

TEST_CASE("rooms and doorways leave the route free, stand on their ground and have no holes", "[worlds]") {
  const double scale = GENERATE(0.2, 0.5, 1.0, 2.0);
  CAPTURE(scale);
  const auto [scene, route] = shipped("doorway_360", scale);
  const DoorwayParams& params = scene.world.doorway;
  const World world = build_doorway(params, route, scale);
  CHECK(worst_clearance(world, route, doorway_doors(params, route), kDoorReach) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(share_of_hits(world, caster, route) > 0.999);
}

TEST_CASE("the seed of rooms and doorways gives their bits", "[worlds]") {
  const auto [scene, route] = shipped("doorway_360", 1);
  DoorwayParams params = scene.world.doorway;
  const World first = build_doorway(params, route, 1);
  CHECK(same_bits(first.mesh, build_doorway(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_doorway(params, route, 1).mesh));
}

TEST_CASE("any seed of rooms and doorways leaves the route free", "[worlds]") {
  const auto [scene, route] = shipped("doorway_360", 1);
  DoorwayParams params = scene.world.doorway;
  params.clutter = 3;
  params.stairwells = 3;
  for (params.seed = 100; params.seed < 115; ++params.seed) {
    CAPTURE(params.seed);
    const World world = build_doorway(params, route, 1);
    CHECK(worst_clearance(world, route, doorway_doors(params, route), kDoorReach) >= 1 - 1e-6);
    CHECK(share_of_hits(world, Caster(world.mesh), route) > 0.999);
  }
}

TEST_CASE("every doorway of the route is as narrow as asked", "[worlds]") {
  const auto [scene, route] = shipped("doorway_360", 1);
  const DoorwayParams& params = scene.world.doorway;
  const Caster caster(build_doorway(params, route, 1).mesh);
  const std::vector<Vec2> doors = doorway_doors(params, route);
  CHECK(doors.size() >= 8);
  for (const Vec2& door : doors) {
    CHECK(route.distance(door) < 1e-9);
    double least = 100;
    for (const Vec3& across : {Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
      const Vec3 eye(door.x(), door.y(), 1.4);
      least = std::min(least, caster.cast(eye, across, 100).range + caster.cast(eye, -across, 100).range);
    }
    CHECK(least > params.door_min - 0.05);
    CHECK(least < params.door_max + 0.01);
  }
}

TEST_CASE("a stairwell has steps that lead up and down, seen from the route", "[worlds]") {
  const auto [scene, route] = shipped("doorway_360", 1);
  DoorwayParams params = scene.world.doorway;
  const Caster with(build_doorway(params, route, 1).mesh);
  params.stairwells = 0;
  const Caster without(build_doorway(params, route, 1).mesh);
  // Only stairs reach below the floor and above the ceilings of the rooms.
  const auto rays_beyond = [&](const Caster& caster) {
    const std::vector<Vec3> directions = directions_all_round(4000);
    int below = 0, above = 0;
    for (double s = 0; s < route.length(); s += 0.5) {
      const Vec3 eye(route.at(s).at.x(), route.at(s).at.y(), 1.4);
      for (const Vec3& d : directions) {
        const double z = (eye + caster.cast(eye, d, 100).range * d).z();
        below += z < -0.1 ? 1 : 0;
        above += z > params.height + 0.1 ? 1 : 0;
      }
    }
    return std::pair(below, above);
  };
  CHECK(rays_beyond(with).first > 50);
  CHECK(rays_beyond(with).second > 50);
  CHECK(rays_beyond(without) == std::pair(0, 0));
}

TEST_CASE("doorways ask for edges parallel to the axes and name the one that is not", "[worlds]") {
  const Route route({{0, 0}, {10, 0}, {10, 8}, {1, 7}});
  CHECK_THROWS_WITH(build_doorway({}, route, 1),
                    Catch::Matchers::Contains("edge 2 from (10.00, 8.00) to (1.00, 7.00)"));
}
