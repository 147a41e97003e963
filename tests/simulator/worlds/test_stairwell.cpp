/// The stairwell as it is shipped: the walk climbs its steps, nothing is in its way, and it has no holes.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/climb.hpp"
#include "aslio/simulator/route_walk.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

namespace {

/// Places along the route with the height that the walk has climbed there.
struct Stride {
  Vec3 at = Vec3::Zero();
  Vec2 along = Vec2::UnitX();
  bool at_door = false;
};

std::vector<Stride> strides(const World& world, const StairwellParams& params, const Route& route, double step) {
  std::vector<Stride> places;
  const std::vector<Vec3> doors = stairwell_doors(params, route);
  for (double s = 0; s < route.length(); s += step) {
    const Route::Place p = route.at(s);
    const Vec3 at(p.at.x(), p.at.y(), world.ground.height(p.at.x(), p.at.y()) + climbed(route, world.climbs, s));
    const bool at_door = std::any_of(doors.begin(), doors.end(), [&](const Vec3& d) { return (d - at).norm() < 0.6; });
    places.push_back({at, p.direction, at_door});
  }
  return places;
}

/// Least distance, to the sides and ahead to the next place, of what is 0.3 to 2.1 m above the walk [share of what must
/// be free].
double least_room(const Caster& caster, const std::vector<Stride>& places) {
  double least = 100;
  for (std::size_t k = 0; k + 1 < places.size(); ++k) {
    const Stride &here = places[k], &next = places[k + 1];
    for (double up = 0.3; up < 2.15; up += 0.2) {
      const Vec3 from = here.at + Vec3(0, 0, up), step = next.at - here.at;
      for (const double side : {-1.0, 1.0}) {
        const Vec3 across(-side * here.along.y(), side * here.along.x(), 0);
        least = std::min(least, caster.cast(from, across, 100).range / (here.at_door ? 0.35 : 0.6));
      }
      if (caster.cast(from, step.normalized(), step.norm()).range <= step.norm()) return 0;
    }
  }
  return least;
}

}  // namespace

TEST_CASE("a stairwell leaves its walk free on every storey, up and down", "[worlds]") {
  const auto [scene, route] = shipped("stairwell", 1);
  StairwellParams params = scene.world.stairwell;
  for (params.seed = 3; params.seed < 9; ++params.seed) {
    CAPTURE(params.seed);
    const World world = build_stairwell(params, route, 1);
    CHECK(least_room(Caster(world.mesh), strides(world, params, route, 0.1)) >= 1 - 1e-6);
  }
}

TEST_CASE("the walk stands on the steps of a stairwell, and on its floors between them", "[worlds]") {
  const auto [scene, route] = shipped("stairwell", 1);
  const World world = build_stairwell(scene.world.stairwell, route, 1);
  const Caster caster(world.mesh);
  double worst = 0, highest = 0;
  std::size_t level = 0;
  const std::vector<Stride> places = strides(world, scene.world.stairwell, route, 0.05);
  for (const Stride& place : places) {
    const double off = caster.cast(place.at + Vec3(0, 0, 1), -Vec3::UnitZ(), 10).range - 1;
    worst = std::max(worst, std::abs(off));
    level += std::abs(off) < 1e-3 ? 1 : 0;
    highest = std::max(highest, place.at.z());
  }
  CHECK(worst < 0.165);  // less than one step
  CHECK(level > places.size() / 3);
  CHECK(highest == Approx(9.9).margin(1e-9));
  CHECK(std::abs(climbed(route, world.climbs, route.length())) < 1e-9);
}

TEST_CASE("a stairwell has no holes, and its seed gives its bits", "[worlds]") {
  const auto [scene, route] = shipped("stairwell", 1);
  StairwellParams params = scene.world.stairwell;
  const World world = build_stairwell(params, route, 1);
  const Caster caster(world.mesh);
  const std::vector<Vec3> directions = directions_all_round(1000);
  std::vector<SurfaceHit> hits(directions.size());
  std::size_t rays = 0, found = 0;
  for (const Stride& place : strides(world, params, route, 0.5)) {
    caster.cast(place.at + Vec3(0, 0, 1.4), directions, 100, hits);
    for (const SurfaceHit& hit : hits) found += std::isfinite(hit.range) ? 1 : 0;
    rays += hits.size();
  }
  CHECK(static_cast<double>(found) > 0.999 * static_cast<double>(rays));
  CHECK(same_bits(world.mesh, build_stairwell(params, route, 1).mesh));
  params.seed += 1;
  CHECK_FALSE(same_bits(world.mesh, build_stairwell(params, route, 1).mesh));
}

TEST_CASE("a climbing walk has the velocity and acceleration of its positions", "[worlds]") {
  const auto [scene, route] = shipped("stairwell", 1);
  World world = build_stairwell(scene.world.stairwell, route, 1);
  WalkParams walk = scene.walk;
  walk.laps = 2;
  const auto plain = make_route_walk(route, world.ground, walk, 5);
  const auto motion =
      make_climbing(make_route_walk(route, world.ground, walk, 5), *plain, route, std::move(world.climbs));
  constexpr double kH = 1e-4;
  double worst_v = 0, worst_a = 0, highest = 0;
  for (double t = 0.5; t < motion->duration() - 0.5; t += 0.0371) {
    const MotionState m = motion->at(t), before = motion->at(t - kH), after = motion->at(t + kH);
    worst_v = std::max(worst_v, ((after.p - before.p) / (2 * kH) - m.v).norm());
    worst_a = std::max(worst_a, ((after.v - before.v) / (2 * kH) - m.a).norm());
    if (t > 0.5 * motion->duration()) highest = std::max(highest, m.p.z());
  }
  CHECK(worst_v < 1e-5);
  CHECK(worst_a < 1e-3);
  CHECK(highest == Approx(9.9 + 1.4).margin(0.03));  // in the second round, too
  CHECK((motion->at(motion->duration()).p - motion->at(0).p).norm() < 1e-9);
}

TEST_CASE("a stairwell of other sizes can be walked on the route that it asks for", "[worlds]") {
  StairwellParams params;
  params.storeys = 2;
  params.width = 2;
  params.gap = 1.5;
  params.storey_height = 4;
  const Route route(stairwell_route(params));
  const World world = build_stairwell(params, route, 1);
  CHECK(least_room(Caster(world.mesh), strides(world, params, route, 0.1)) >= 1 - 1e-6);
}

TEST_CASE("a stairwell names the point that is off its stairs, and gives the right route", "[worlds]") {
  const auto [scene, route] = shipped("stairwell", 1);
  std::vector<Vec2> points = route.points();
  points[4] += Vec2(0.3, 0);
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(build_stairwell(scene.world.stairwell, Route(points), 1),
                    Contains("point 5 at (") && Contains("give route: [{x: 0.000, y: 0.000}"));
  points.resize(9);
  points[4] = route.points()[4];
  CHECK_THROWS_WITH(build_stairwell(scene.world.stairwell, Route(points), 1), Contains("point 10 is missing"));
  CHECK_THROWS_WITH(build_stairwell(scene.world.stairwell, route, 0.5), Contains("scale 1") && Contains("storeys"));
  CHECK_THROWS_WITH(load_scene(ASLIO_SOURCE_DIR "/configs/scenes/stairwell.yaml", {"people.walking=1"}),
                    Contains("people") && Contains("one level"));
}
