#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/people.hpp"
#include "aslio/simulator/random.hpp"
#include "ring.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr PeopleParams kCrowd{.walking = 8, .ahead = 3, .crossing = 5, .distance = 4, .lateral = 0.7};

Ground waves() { return {.waves = {{0.3, 0.2, 0.1, 0.4}}, .ramps = {}}; }

struct Setting {
  Route route = test::ring();
  Ground ground = waves();
  std::unique_ptr<Motion> sensor = test::round(route, 1.3);
  People people{kCrowd, route, ground, *sensor, 1};
};

Vec2 plan(const Vec3& p) { return p.head<2>(); }

}  // namespace

TEST_CASE("people move smoothly and upright on the ground", "[people]") {
  const Setting s;
  REQUIRE(s.people.size() == 16);
  constexpr double kStep = 0.01;
  std::vector<Body> before, now;
  std::vector<Vec3> velocity(s.people.size(), Vec3::Zero());
  s.people.at(0, before);
  double least_swing = 1e9, most_swing = 0;
  for (int k = 1; k < 6000; ++k) {
    s.people.at(kStep * k, now);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Vec3 v = (now[i].centre - before[i].centre) / kStep;
      REQUIRE(plan(v).norm() > 0.6);
      REQUIRE(plan(v).norm() < 1.6);
      if (k > 1) REQUIRE((v - velocity[i]).norm() < 10 * kStep);
      velocity[i] = v;
      for (std::size_t part = 0; part < kBodyParts; ++part) {
        const Capsule &c = now[i].parts[part], &d = before[i].parts[part];
        REQUIRE((c.a - d.a).norm() < 6 * kStep);
        REQUIRE((c.b - d.b).norm() < 6 * kStep);
        for (const Vec3& end : {c.a, c.b}) REQUIRE((end - now[i].centre).norm() + c.radius <= now[i].radius);
      }
      const Capsule& torso = now[i].parts[0];
      REQUIRE(plan(torso.b - torso.a).norm() < 1e-12);
      const Vec3 feet = s.people.position(i, kStep * k);
      REQUIRE(std::abs(feet.z() - s.ground.height(feet.x(), feet.y())) < 0.01);
      const double swing = (now[i].parts[2].b - now[i].parts[3].b).norm();
      least_swing = std::min(least_swing, swing);
      most_swing = std::max(most_swing, swing);
    }
    before = now;
  }
  // Feet pass each other and stride.
  CHECK(least_swing < 0.2);
  CHECK(most_swing > 0.5);
}

TEST_CASE("nobody comes near the sensor", "[people]") {
  for (const double speed : {0.8, 1.3, 3.0}) {
    const Route route = test::ring();
    const auto sensor = test::round(route, speed);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const People people(kCrowd, route, {}, *sensor, seed);
      double nearest = 1e9;
      std::vector<Body> bodies;
      for (double t = 0; t <= sensor->duration(); t += 0.013) {
        const Vec3 p = sensor->at(t).p + Vec3(0, 0, 1.4);
        for (std::size_t i = 0; i < people.size(); ++i)
          nearest = std::min(nearest, (plan(people.position(i, t)) - plan(p)).norm());
        people.at(t, bodies);
        for (const Body& body : bodies) {
          for (const Capsule& c : body.parts) {
            for (const Vec3& end : {c.a, c.b}) REQUIRE((end - p).norm() > c.radius + 0.1);
          }
        }
      }
      CHECK(nearest > People::kClearance - 0.02);
    }
  }
}

TEST_CASE("walking people keep beside the line of the route, on their right", "[people]") {
  const Route route({{0, 0}, {30, 0}, {30, 12}, {0, 12}});
  const auto sensor = test::round(route, 1.3);
  const People people({.walking = 8}, route, {}, *sensor, 2);
  int forth = 0, back = 0;
  for (std::size_t i = 0; i < people.size(); ++i) {
    for (double t = 0; t < 60; t += 0.05) {
      const Vec2 p = plan(people.position(i, t));
      const double beside = route.distance(p);
      REQUIRE(beside > 0.6);
      REQUIRE(beside < 1.0);
      const Vec2 v = plan(people.position(i, t + 0.01)) - p;
      // Along the first edge the right of someone who walks forth is y < 0.
      if (p.x() < 3 || p.x() > 27 || p.y() > 3) continue;
      REQUIRE(v.x() * p.y() < 0);
      REQUIRE(std::abs(p.y()) == Approx(0.7).margin(1e-6));
      (v.x() > 0 ? forth : back) += 1;
    }
  }
  CHECK(forth > 0);
  CHECK(back > 0);
}

TEST_CASE("people ahead of the sensor are ahead of it", "[people]") {
  const Route route({{0, 0}, {40, 0}, {40, 20}, {0, 20}});
  const auto sensor = test::round(route, 1.3);
  const People people({.ahead = 3, .distance = 4}, route, {}, *sensor, 3);
  int seen = 0;
  for (double t = 0; t < sensor->duration(); t += 0.1) {
    const MotionState m = sensor->at(t);
    // On the straight part of the first and third edge.
    const double sign = m.p.y() < 1 ? 1 : -1;
    if ((m.p.y() > 0.1 && m.p.y() < 19.9) || m.p.x() < 5 || m.p.x() > 35) continue;
    std::array<double, 3> ahead{};
    bool round_the_corner = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 p = plan(people.position(i, t));
      ahead[i] = sign * (p - plan(m.p)).x();
      round_the_corner = round_the_corner || p.x() < 1 || p.x() > 39;
    }
    if (round_the_corner) continue;
    ++seen;
    REQUIRE(ahead[0] > 2.5);
    REQUIRE(ahead[1] > 2.5);
    REQUIRE(ahead[2] == Approx(ahead[0] + 3).margin(0.3));  // on the same side
  }
  CHECK(seen > 100);
}

TEST_CASE("crossing people go to and fro across the route and stay beside it", "[people]") {
  const Setting s;
  for (std::size_t i = 11; i < 16; ++i) {
    double farthest = 0, nearest = 1e9;
    for (double t = 0; t < 10; t += 0.01) {
      const double d = s.route.distance(plan(s.people.position(i, t)));
      farthest = std::max(farthest, d);
      nearest = std::min(nearest, d);
    }
    CHECK(farthest < 0.9);
    CHECK(nearest < 0.02);
  }
}

TEST_CASE("rays aimed at a body meet it where it is", "[people]") {
  const Setting s;
  RandomStream random(4, 4);
  std::vector<Body> bodies;
  for (int trial = 0; trial < 2000; ++trial) {
    s.people.at(random.uniform(0, 60), bodies);
    const Body& body = bodies[static_cast<std::size_t>(trial) % bodies.size()];
    const Capsule& part = body.parts[static_cast<std::size_t>(trial / 16) % kBodyParts];
    const double azimuth = random.uniform(0, 6.28), elevation = random.uniform(-0.3, 1.2);
    const Vec3 away(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                    std::sin(elevation));
    const Vec3 target = part.a + random.uniform() * (part.b - part.a);
    const Vec3 origin = target + 3 * away;
    SurfaceHit hit;
    cast_people({&body, 1}, origin, -away, hit);
    REQUIRE(hit.moving);
    REQUIRE(hit.range <= 3 - part.radius + 1e-9);
    REQUIRE(hit.range > 3 - 2 * body.radius);
    double surface = 1e9;
    for (const Capsule& c : body.parts) {
      const Vec3 p = origin - hit.range * away, axis = c.b - c.a;
      const double u = std::clamp((p - c.a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
      surface = std::min(surface, std::abs((p - c.a - u * axis).norm() - c.radius));
    }
    REQUIRE(surface < 1e-9);
  }
}

TEST_CASE("bodies in view are those that rays meet", "[people]") {
  const Setting s;
  RandomStream random(5, 5);
  std::vector<Body> all, seen;
  int hits = 0;
  std::size_t in_view = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const double t = random.uniform(0, 60), azimuth = random.uniform(0, 6.28);
    const Vec3 origin = s.sensor->at(t).p + Vec3(0, 0, 1.4);
    std::vector<Vec3> directions;
    for (int beam = 0; beam < 6; ++beam) {
      const double elevation = 0.025 * beam - 0.1;
      directions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
    }
    s.people.at(t, all);
    s.people.in_view(t, origin, directions, seen);
    in_view += seen.size();
    for (const Vec3& direction : directions) {
      SurfaceHit a, b;
      cast_people(all, origin, direction, a);
      cast_people(seen, origin, direction, b);
      REQUIRE(a.range == b.range);
      REQUIRE(a.cos_incidence == b.cos_incidence);
      hits += a.moving;
    }
  }
  CHECK(hits > 1000);
  CHECK(in_view < 20'000 * s.people.size() / 5);
}

TEST_CASE("equal seeds give the same people, and one kind does not change another", "[people]") {
  const Setting a, b;
  const People other(kCrowd, a.route, a.ground, *a.sensor, 2);
  const People walking_only({.walking = 8}, a.route, a.ground, *a.sensor, 1);
  int different = 0;
  for (std::size_t i = 0; i < a.people.size(); ++i) {
    REQUIRE(a.people.position(i, 12.3) == b.people.position(i, 12.3));
    different += a.people.position(i, 12.3) != other.position(i, 12.3);
    if (i < 8) REQUIRE(a.people.position(i, 12.3) == walking_only.position(i, 12.3));
  }
  CHECK(different >= 13);
  CHECK(People().size() == 0);
}

TEST_CASE("people whom the sensor cannot pass are an error that says what to do", "[people]") {
  // The sensor stands 0.6 m off the line all the time, over a short round that a walker has to use.
  const Route route({{0, 0}, {1.2, 0}});
  const Walk standing({{0, 0.6, 0.7, 0, 0}, {100, 0.6, 0.7, 0, 0}}, {}, {}, 1);
  try {
    People({.walking = 1}, route, {}, standing, 1);
    FAIL("no error");
  } catch (const ConfigError& error) {
    CHECK_THAT(error.what(), Catch::Contains("people.walking") && Catch::Contains("people.lateral"));
  }
}
