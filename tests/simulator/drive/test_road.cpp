#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "roads.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;

TEST_CASE("a road begins and ends at its points, along its edges") {
  const RoadLine road = simulator::test::bent_road();
  CHECK(road.at(0).at.norm() < 1e-12);
  CHECK((road.at(road.length()).at - Vec2(280, 40)).norm() < 1e-9);
  CHECK(road.at(0).heading == 0);
  CHECK(std::abs(road.at(road.length()).heading + std::numbers::pi / 4) < 1e-12);
  CHECK((road.at(-50).at - Vec2(-50, 0)).norm() < 1e-12);
  CHECK((road.at(10).beside(3) - Vec2(10, 3)).norm() < 1e-12);
}

TEST_CASE("the way along a road is its length, and heading and curvature are its derivatives") {
  const RoadLine road = simulator::test::bent_road();
  constexpr double h = 1e-4;
  for (double s = -5; s < road.length() + 5; s += 0.37) {
    const RoadLine::Place p = road.at(s), before = road.at(s - h), after = road.at(s + h);
    CAPTURE(s);
    const Vec2 tangent = (after.at - before.at) / (2 * h);
    REQUIRE((tangent - Vec2(std::cos(p.heading), std::sin(p.heading))).norm() < 1e-7);
    REQUIRE(std::abs((after.heading - before.heading) / (2 * h) - p.curvature) < 1e-7);
    REQUIRE(std::abs((after.curvature - before.curvature) / (2 * h) - p.curvature_slope) < 1e-7);
  }
}

TEST_CASE("bends have the radius asked for where there is room, and lie on their corners") {
  const RoadLine road = simulator::test::bent_road();
  REQUIRE(road.bends().size() == 3);
  CHECK(road.bends()[0].angle == Approx(std::numbers::pi / 2));
  CHECK(road.bends()[1].angle == Approx(-std::numbers::pi / 4));
  CHECK(road.bends()[2].angle == Approx(-std::numbers::pi / 2));
  for (const RoadLine::Bend& bend : road.bends()) {
    CHECK(bend.radius() == Approx(12));
    double tightest = 0;
    for (double s = bend.begin; s < bend.begin + bend.length; s += 0.01)
      tightest = std::max(tightest, std::abs(road.at(s).curvature));
    CHECK(tightest == Approx(1 / 12.).epsilon(1e-5));
  }
  // Wide bends on short edges become tighter, not longer than the edges.
  const RoadLine wide({{0, 0}, {40, 0}, {40, 40}}, 1000);
  REQUIRE(wide.bends().size() == 1);
  CHECK(wide.bends()[0].radius() < 20);
  CHECK((wide.at(wide.length()).at - Vec2(40, 40)).norm() < 1e-9);
}

TEST_CASE("roads that cannot be driven are refused") {
  CHECK_THROWS_WITH(RoadLine({{0, 0}}, 10), Contains("needs at least 2"));
  CHECK_THROWS_WITH(RoadLine({{0, 0}, {0.5, 0}}, 10), Contains("edge 1") && Contains("at least 1 m"));
  CHECK_THROWS_WITH(RoadLine({{0, 0}, {50, 0}, {0, 5}}, 10), Contains("point 2") && Contains("at most 150"));
}
