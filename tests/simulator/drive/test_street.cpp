#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/worlds/street.hpp"
#include "roads.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

StreetParams motorway() {
  StreetParams params;
  params.lanes = 2;
  params.median = 4;
  params.pavement = 0;
  params.guard_rails = 1;
  params.houses = 0;
  params.side_streets = 0;
  params.parked = 0;
  params.bridges = 200;
  return params;
}

/// Nearest surface to the right and to the left of the middle of the lane, at a height, every metre of the road.
std::vector<double> beside(const World& world, const Caster& caster, const RoadLine& road, double height, double side) {
  std::vector<double> ranges;
  for (double s = 0; s < road.length(); s += 1) {
    const RoadLine::Place place = road.at(s);
    const Vec3 out(-side * std::sin(place.heading), side * std::cos(place.heading), 0);
    ranges.push_back(
        caster.cast(Vec3(place.at.x(), place.at.y(), world.ground.height(place.at.x(), place.at.y()) + height), out, 60)
            .range);
  }
  return ranges;
}

}  // namespace

TEST_CASE("nothing stands in the lanes of a street, and the road lies on the ground", "[street]") {
  const RoadLine road = bent_road();
  for (const StreetParams& params : {StreetParams{}, motorway()}) {
    const World world = build_street(params, road);
    const Caster caster(world.mesh);
    std::vector<double> lanes{0};
    if (params.lanes > 1) lanes.push_back(params.lane_along(1));
    for (std::int64_t k = 0; k < params.lanes; ++k) lanes.push_back(params.lane_against(k));
    for (double s = -20; s < road.length() + 20; s += 0.5) {
      const RoadLine::Place place = road.at(s);
      for (const double y : lanes) {
        // A box of 2.4 m by 2.3 m, as rays along the road, half a metre each.
        for (const double side : {-1.2, 0.0, 1.2})
          for (const double up : {0.25, 1.0, 2.3}) {
            const Vec2 a = place.beside(y + side), b = road.at(s + 0.5).beside(y + side);
            const Vec3 from(a.x(), a.y(), world.ground.height(a.x(), a.y()) + up);
            const Vec3 to(b.x(), b.y(), world.ground.height(b.x(), b.y()) + up);
            CAPTURE(s, y, side, up);
            REQUIRE(caster.cast(from, (to - from).normalized(), (to - from).norm()).range > 1e9);
          }
        const Vec2 p = place.beside(y);
        const double z = world.ground.height(p.x(), p.y());
        REQUIRE(caster.cast(Vec3(p.x(), p.y(), z + 0.2), -Vec3::UnitZ(), 5).range == Approx(0.2).margin(0.012));
      }
    }
  }
}

TEST_CASE("a city street has houses on both sides and gaps where side streets are", "[street]") {
  const RoadLine road({{0, 0}, {400, 0}}, 20);
  StreetParams params;
  params.parked = 0;
  params.trees = 0;
  const World world = build_street(params, road);
  const Caster caster(world.mesh);
  for (const double side : {-1.0, 1.0}) {
    const std::vector<double> ranges = beside(world, caster, road, 4, side);
    const auto near = static_cast<double>(std::count_if(ranges.begin(), ranges.end(), [](double r) { return r < 20; }));
    CHECK(near > 0.35 * static_cast<double>(ranges.size()));
    CHECK(near < 0.97 * static_cast<double>(ranges.size()));
  }
  params.houses = 0;
  const World bare = build_street(params, road);
  const Caster bare_caster(bare.mesh);
  for (const double r : beside(bare, bare_caster, road, 4, 1)) REQUIRE(r > 2);
}

TEST_CASE("a motorway has guard rails at one distance all along", "[street]") {
  const RoadLine road({{0, 0}, {400, 0}}, 20);
  const StreetParams params = motorway();
  const World world = build_street(params, road);
  const Caster caster(world.mesh);
  for (const double r : beside(world, caster, road, 0.6, -1))
    REQUIRE(r == Approx(0.35 - params.right_edge()).margin(0.1));
  for (const double r : beside(world, caster, road, 0.6, 1)) REQUIRE(r == Approx(1.5 * params.lane + 0.3).margin(0.1));
}

TEST_CASE("equal seeds give equal streets, others do not, and memory stays small", "[street]") {
  const RoadLine road = bent_road();
  const World a = build_street({}, road), b = build_street({}, road);
  CHECK(simulator::testing::same_bits(a.mesh, b.mesh));
  StreetParams other;
  other.seed = 2;
  CHECK_FALSE(simulator::testing::same_bits(a.mesh, build_street(other, road).mesh));
  CHECK(a.mesh.triangles.size() < 1'500'000);
}
