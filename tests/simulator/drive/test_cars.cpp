#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/cars.hpp"
#include "aslio/simulator/random.hpp"
#include "roads.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

struct Traffic {
  StreetParams street = two_lanes();
  Drive sensor{bent_road(), hills(), stop_and_go(), 1};
  Cars cars{{.ahead = 2, .behind = 1, .oncoming = 6, .beside = 3}, street, hills(), sensor, 5};

  static StreetParams two_lanes() {
    StreetParams street;
    street.lanes = 2;
    return street;
  }
};

/// Of a point to the left of the road's line, near a place of it [m].
double left_of_road(const RoadLine& road, double s, const Vec3& p) {
  const RoadLine::Place place = road.at(s);
  return (p.head<2>() - place.at).dot(Vec2(-std::sin(place.heading), std::cos(place.heading)));
}

}  // namespace

TEST_CASE("cars drive in the middles of their lanes, on the ground, the way that their lane goes", "[cars]") {
  const Traffic t;
  const RoadLine& road = t.sensor.road();
  REQUIRE(t.cars.size() == 12);
  const Ground ground = hills();
  for (std::size_t k = 0; k < t.cars.size(); ++k)
    for (double time = 0; time < t.sensor.duration(); time += 0.5) {
      CAPTURE(k, time);
      const double s = t.cars.way(k, time);
      const CarBody car = t.cars.body(k, time);
      const double left = left_of_road(road, s, car.at);
      const Vec2 ahead(std::cos(road.at(s).heading), std::sin(road.at(s).heading));
      const double along = ahead.dot(Vec2(car.cos_yaw, car.sin_yaw));
      REQUIRE(car.at.z() == Approx(ground.height(car.at.x(), car.at.y())));
      const double moved = t.cars.way(k, time + 0.01) - s;
      switch (t.cars.lane(k)) {
        case Cars::Lane::ahead:
          REQUIRE(std::abs(left) < 1e-9);
          REQUIRE(s > t.sensor.way(time) + 10);
          break;
        case Cars::Lane::behind:
          REQUIRE(std::abs(left) < 1e-9);
          REQUIRE(s < t.sensor.way(time) - 10);
          break;
        case Cars::Lane::beside:
          REQUIRE(left == Approx(3.5));
          REQUIRE(moved > 0);
          break;
        case Cars::Lane::oncoming:
          REQUIRE((std::abs(left - 7) < 1e-9 || std::abs(left - 10.5) < 1e-9));
          REQUIRE(moved < 0);
          break;
      }
      REQUIRE(along == Approx(t.cars.lane(k) == Cars::Lane::oncoming ? -1 : 1));
    }
}

TEST_CASE("cars ahead stop when the sensor stops, and oncoming ones pass it", "[cars]") {
  const Traffic t;
  double standing = -1;
  for (double time = 0; time < t.sensor.duration() && standing < 0; time += 0.05)
    if (t.sensor.speed(time) == 0) standing = time + 0.2;
  REQUIRE(standing > 0);
  CHECK((t.cars.body(0, standing).at - t.cars.body(0, standing + 0.5).at).norm() == 0);
  int passed = 0;
  for (std::size_t k = 0; k < t.cars.size(); ++k) {
    if (t.cars.lane(k) != Cars::Lane::oncoming) continue;
    const double end = t.sensor.duration();
    passed += t.cars.way(k, 0) > t.sensor.way(0) && t.cars.way(k, end) < t.sensor.way(end);
  }
  CHECK(passed >= 5);
}

TEST_CASE("no car touches another one or the sensor", "[cars]") {
  const Traffic t;
  for (double time = 0; time < t.sensor.duration(); time += 0.25) {
    const Vec3 own = t.sensor.at(time).p;
    for (std::size_t i = 0; i < t.cars.size(); ++i) {
      const CarBody a = t.cars.body(i, time);
      REQUIRE((a.at.head<2>() - own.head<2>()).norm() > 2.5);
      for (std::size_t k = 0; k < i; ++k) {
        const CarBody b = t.cars.body(k, time);
        REQUIRE((a.at - b.at).head<2>().norm() > 2.5);
      }
    }
  }
}

TEST_CASE("rays aimed at a car meet its surface, and cars in view are those that rays meet", "[cars]") {
  const Traffic t;
  RandomStream random(4, 4);
  std::vector<CarBody> seen;
  int hits = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double time = random.uniform(0, t.sensor.duration());
    const CarBody car = t.cars.body(static_cast<std::size_t>(trial) % t.cars.size(), time);
    const CarBody::Part& part = car.parts[static_cast<std::size_t>(trial / 12) % 2];
    const auto world = [&](const Vec3& p) -> Vec3 {
      return car.at + Vec3(car.cos_yaw * p.x() - car.sin_yaw * p.y(), car.sin_yaw * p.x() + car.cos_yaw * p.y(), p.z());
    };
    const Vec3 target =
        part.centre +
        Vec3(random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9)).cwiseProduct(part.half);
    const double azimuth = random.uniform(0, 6.28), elevation = random.uniform(0, 0.6);
    const Vec3 away(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                    std::sin(elevation));
    const Vec3 origin = world(target) + 12 * away;
    SurfaceHit hit;
    cast_cars({&car, 1}, origin, -away, hit);
    REQUIRE(hit.moving);
    REQUIRE(hit.range < 12);
    REQUIRE(hit.cos_incidence > 0);
    REQUIRE(hit.cos_incidence <= 1);
    // On the surface of one of the boxes, and in none.
    const Vec3 in_world = origin - hit.range * away - car.at;
    const Vec3 p(car.cos_yaw * in_world.x() + car.sin_yaw * in_world.y(),
                 car.cos_yaw * in_world.y() - car.sin_yaw * in_world.x(), in_world.z());
    double off = 1e9;
    for (const CarBody::Part& box : car.parts)
      off = std::min(off, std::abs(((p - box.centre).cwiseAbs() - box.half).maxCoeff()));
    REQUIRE(off < 1e-9);
    t.cars.in_view(time, origin, std::vector<Vec3>{-away}, seen);
    SurfaceHit again;
    cast_cars(seen, origin, -away, again);
    REQUIRE(again.range <= hit.range);
    hits += again.range == hit.range;
  }
  CHECK(hits > 2000);
}

TEST_CASE("cars beside need a second lane", "[cars]") {
  const Traffic t;
  CHECK_THROWS_WITH(Cars({.beside = 1}, StreetParams{}, Ground{}, t.sensor, 1), Catch::Contains("cars.beside"));
}
