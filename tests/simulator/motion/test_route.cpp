#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/route.hpp"

using namespace aslio;
using namespace aslio::simulator;

TEST_CASE("a route is a closed line: places repeat with every round, in both directions") {
  const Route route({{0, 0}, {4, 0}, {4, 3}});
  CHECK(route.length() == Approx(12));
  for (const double round : {-24.0, -12.0, 0.0, 12.0, 1200.0}) {
    CAPTURE(round);
    CHECK((route.at(round + 1).at - Vec2(1, 0)).norm() < 1e-9);
    CHECK((route.at(round + 5).at - Vec2(4, 1)).norm() < 1e-9);
    CHECK((route.at(round + 5).direction - Vec2(0, 1)).norm() < 1e-12);
    CHECK((route.at(round + 9.5).at - Vec2(2, 1.5)).norm() < 1e-9);
    CHECK((route.at(round + 9.5).direction - Vec2(-0.8, -0.6)).norm() < 1e-12);
  }
  CHECK((route.at(4).direction - Vec2(0, 1)).norm() < 1e-12);
}

TEST_CASE("distance to a route and the rectangle round it") {
  const Route route({{0, 0}, {4, 0}, {4, 3}});
  CHECK(route.distance({2, -1}) == Approx(1));
  CHECK(route.distance({7, 7}) == Approx(5));
  CHECK(route.distance({2, 1.5}) < 1e-12);
  CHECK(route.low() == Vec2(0, 0));
  CHECK(route.high() == Vec2(4, 3));
}

TEST_CASE("routes that cannot be walked are refused by their edge") {
  CHECK_THROWS_WITH(Route({{1, 1}}), "route: has 1 points, needs at least 2: the start and one more");
  CHECK_THROWS_WITH(Route({{0, 0}, {5, 0}, {5, 0.2}, {0, 3}}),
                    Catch::Contains("edge 2 from (5, 0) to (5, 0.2) is 0.2 m long"));
  CHECK_THROWS_WITH(Route({{0, 0}, {5, 0}, {0, 0}}), Catch::Contains("edge 3 from (0, 0) to (0, 0)"));
  CHECK_THROWS_AS(Route({{0, 0}, {std::nan(""), 0}, {1, 1}}), ConfigError);
  CHECK_THROWS_AS(Route({{0, 0}, {std::numeric_limits<double>::infinity(), 0}}), ConfigError);
}
