#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/people.hpp"
#include "aslio/simulator/random.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

double distance(const Vec3& p, const Capsule& c) {
  const Vec3 axis = c.b - c.a;
  const double u = std::clamp((p - c.a).dot(axis) / std::max(axis.squaredNorm(), 1e-30), 0.0, 1.0);
  return (p - c.a - u * axis).norm() - c.radius;
}

double distance(const Vec3& p, const Body& body) {
  double nearest = 1e9;
  for (const Capsule& c : body.parts) nearest = std::min(nearest, distance(p, c));
  return nearest;
}

/// Where a ray meets a body, by steps of the distance that is surely free; infinite when it passes by.
double marched(const Body& body, const Vec3& origin, const Vec3& direction) {
  double range = 0;
  for (int step = 0; step < 100'000 && range < 50; ++step) {
    const double free = distance(origin + range * direction, body);
    if (free < 1e-9) return range;
    range += free;
  }
  return std::numeric_limits<double>::infinity();
}

Vec3 random_vector(RandomStream& random, double reach) {
  const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach), z = random.uniform(-reach, reach);
  return {x, y, z};
}

Body single(const Capsule& capsule) {
  Body body;
  body.parts.fill(capsule);
  body.centre = 0.5 * (capsule.a + capsule.b);
  body.radius = 0.5 * (capsule.b - capsule.a).norm() + capsule.radius;
  return body;
}

SurfaceHit cast(const Body& body, const Vec3& origin, const Vec3& direction) {
  SurfaceHit hit;
  cast_people({&body, 1}, origin, direction, hit);
  return hit;
}

}  // namespace

TEST_CASE("rays meet a capsule where geometry says", "[people]") {
  const Body upright = single({{0, 0, 0}, {0, 0, 2}, 0.5});
  const SurfaceHit wall = cast(upright, {-5, 0, 1}, Vec3::UnitX());
  CHECK(wall.range == Approx(4.5).epsilon(1e-12));
  CHECK(wall.cos_incidence == Approx(1).epsilon(1e-12));
  CHECK(wall.moving);
  CHECK(wall.reflectivity == 0.35);
  const SurfaceHit off_axis = cast(upright, {-5, 0.3, 1}, Vec3::UnitX());
  CHECK(off_axis.range == Approx(4.6).epsilon(1e-12));
  CHECK(off_axis.cos_incidence == Approx(0.8).epsilon(1e-12));
  // Along the axis, from both ends.
  CHECK(cast(upright, {0, 0, 10}, -Vec3::UnitZ()).range == Approx(7.5).epsilon(1e-12));
  CHECK(cast(upright, {0, 0, -10}, Vec3::UnitZ()).range == Approx(9.5).epsilon(1e-12));
  CHECK(cast(upright, {0.3, 0, 10}, -Vec3::UnitZ()).range == Approx(7.6).epsilon(1e-12));
  // The ball at the upper end.
  CHECK(cast(upright, {-5, 0, 2.3}, Vec3::UnitX()).range == Approx(4.6).epsilon(1e-12));
  // Beside, above, behind.
  CHECK_FALSE(cast(upright, {-5, 0.51, 1}, Vec3::UnitX()).moving);
  CHECK_FALSE(cast(upright, {-5, 0, 2.51}, Vec3::UnitX()).moving);
  CHECK_FALSE(cast(upright, {-5, 0, 1}, -Vec3::UnitX()).moving);
  CHECK_FALSE(cast(upright, {0.6, 0, 10}, -Vec3::UnitZ()).moving);
  CHECK_FALSE(cast(upright, {0, 0, 10}, Vec3::UnitZ()).moving);
}

TEST_CASE("a nearer surface hides a body, a farther one is hidden", "[people]") {
  const Body body = single({{0, 0, 0}, {0, 0, 2}, 0.5});
  SurfaceHit near;
  near.range = 4;
  near.reflectivity = 0.7;
  cast_people({&body, 1}, {-5, 0, 1}, Vec3::UnitX(), near);
  CHECK(near.range == 4);
  CHECK(near.reflectivity == 0.7);
  CHECK_FALSE(near.moving);
  SurfaceHit far;
  far.range = 6;
  cast_people({&body, 1}, {-5, 0, 1}, Vec3::UnitX(), far);
  CHECK(far.range == Approx(4.5));
  CHECK(far.moving);
}

TEST_CASE("rays meet random bodies where marching along them does", "[people]") {
  RandomStream random(1, 1);
  int hits = 0, ends = 0;
  for (int trial = 0; trial < 8000; ++trial) {
    Body body;
    for (Capsule& c : body.parts) {
      c.a = random_vector(random, 1);
      c.b = c.a + random_vector(random, trial % 3 == 0 ? 0.01 : 1);
      c.radius = random.uniform(0.05, 0.3);
    }
    body.radius = 4;
    const Vec3 origin = random_vector(random, 4);
    const Vec3 direction = (random_vector(random, 1) - origin).normalized();
    if (distance(origin, body) < 1e-3) continue;
    const SurfaceHit hit = cast(body, origin, direction);
    const double expected = marched(body, origin, direction);
    if (std::isfinite(expected) != hit.moving) {
      // A grazing ray: the march stops within its tolerance of the surface.
      REQUIRE(std::isfinite(expected));
      REQUIRE(distance(origin + expected * direction, body) < 1e-9);
      ++ends;
      continue;
    }
    if (!hit.moving) continue;
    ++hits;
    REQUIRE(hit.range == Approx(expected).margin(1e-4));
    REQUIRE(std::abs(distance(origin + hit.range * direction, body)) < 1e-9);
    // Incidence against the gradient of the distance.
    Vec3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 p = origin + hit.range * direction, h = 1e-6 * Vec3::Unit(axis);
      gradient[axis] = (distance(p + h, body) - distance(p - h, body)) / 2e-6;
    }
    REQUIRE(hit.cos_incidence == Approx(-direction.dot(gradient)).margin(1e-3));
  }
  CHECK(hits > 1500);
  CHECK(ends <= 2);
}
