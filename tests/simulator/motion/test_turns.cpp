#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "routes.hpp"
#include "swings.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

WalkParams smooth() {
  WalkParams params;
  params.gait = GaitKind::smooth;
  return params;
}

}  // namespace

TEST_CASE("corners of 90 deg are turned in the time drawn for them, with the peak rate of the septic step") {
  const Route square({{0, 0}, {9, 0}, {9, 9}, {0, 9}});
  for (const std::uint64_t seed : {1, 2, 3}) {
    WalkParams params = smooth();
    params.turn_min = 0.45;
    params.turn_max = 0.75;
    const auto found = swings(*make_route_walk(square, Ground{}, params, seed));
    REQUIRE(found.size() == 4);
    for (const Swing& swing : found) {
      CHECK(swing.angle == Approx(90).epsilon(1e-3));
      CHECK(swing.duration > 0.44);
      CHECK(swing.duration < 0.76);
      CHECK(swing.peak == Approx(2.1875 * 90 / swing.duration).epsilon(0.01));
    }
  }
}

TEST_CASE("corners are turned by their angle, to their side, the sharp ones more slowly") {
  const auto found = swings(*make_route_walk(crooked(), Ground{}, smooth(), 1));
  const double angles[] = {90, -50.194, 106.504, 123.690, -90, 90, 90};
  REQUIRE(found.size() == std::size(angles));
  for (std::size_t k = 0; k < found.size(); ++k) {
    CHECK(found[k].angle == Approx(angles[k]).margin(0.1));
    CHECK(found[k].duration > 0.44 * std::max(1.0, std::abs(angles[k]) / 90));
    CHECK(found[k].duration < 0.76 * std::max(1.0, std::abs(angles[k]) / 90));
  }
}

TEST_CASE("glances turn away and back while the walk goes straight on") {
  const Route square({{0, 0}, {20, 0}, {20, 20}, {0, 20}});
  WalkParams params = smooth();
  params.laps = 2;
  const auto plain = make_route_walk(square, Ground{}, params, 1);
  params.glances = {{0.125, 60, 0.5, 0.3}, {0.625, -80, 0.4, 0.0}};
  const auto walk = make_route_walk(square, Ground{}, params, 1);
  const auto found = swings(*walk), corners = swings(*plain);
  REQUIRE(found.size() == corners.size() + 8);
  for (const std::size_t first : {0U, 8U}) {
    CHECK(found[first].angle == Approx(60).epsilon(1e-3));
    CHECK(found[first].duration == Approx(0.5).margin(0.01));
    CHECK(found[first + 1].angle == Approx(-60).epsilon(1e-3));
    CHECK(found[first + 1].begin - found[first].begin == Approx(0.8).margin(0.01));
    CHECK(walk->at(found[first].begin).p.x() == Approx(10).margin(0.2));
    CHECK(found[first + 4].angle == Approx(-80).epsilon(1e-3));
    CHECK(found[first + 5].angle == Approx(80).epsilon(1e-3));
  }
  for (double t = 0; t < walk->duration(); t += 0.05) REQUIRE(walk->at(t).p == plain->at(t).p);
}

TEST_CASE("routes too tight for the walk are refused with their edge and what to do") {
  WalkParams params = smooth();
  params.turn_min = params.turn_max = 5;
  CHECK_THROWS_WITH(make_route_walk(Route({{0, 0}, {4, 0}, {4, 3}, {0, 3}}), Ground{}, params, 1),
                    Catch::Contains("of the route from (") && Catch::Contains("over before the head has turned") &&
                        Catch::Contains("turn_max smaller"));
  params = smooth();
  params.dynamic_start = true;
  params.speed = 8;
  CHECK_THROWS_WITH(make_route_walk(Route({{0, 0}, {4, 0}, {4, 40}, {0, 40}}), Ground{}, params, 1),
                    Catch::Contains("edge 1 of the route from (0, 0) to (4, 0)") &&
                        Catch::Contains("after a dynamic start it is too short to slow down"));
  params = smooth();
  params.standstill = 0;
  params.glances = {{0.99, 60, 2, 5}};
  CHECK_THROWS_WITH(make_route_walk(crooked(), Ground{}, params, 1),
                    Catch::Contains("walk.glances[0]") && Catch::Contains("longer than the walk"));
}
