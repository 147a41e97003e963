/// Curved surfaces are as near to their true shape as they promise, from every side.

#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <numbers>

#include "aslio/simulator/caster.hpp"
#include "worlds/curved.hpp"
#include "worlds/flight.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPromised = 0.002;  // [m]

}  // namespace

TEST_CASE("a round column is a cylinder to 2 mm", "[worlds]") {
  const double radius = GENERATE(0.05, 0.3, 1.0, 5.0);
  CAPTURE(radius);
  MeshBuilder builder;
  curved::add_column(builder, {1, 2, 0}, radius, radius, 3, material::kConcrete);
  const Caster caster(builder.take());
  for (double angle = 0; angle < 2 * kPi; angle += 0.0137) {
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const double range = caster.cast(Vec3(1, 2, 1) + 10 * out, -out, 20).range;
    CHECK(range >= 10 - radius - 1e-6);
    CHECK(range < 10 - radius + kPromised);
  }
}

TEST_CASE("an arc keeps its chords within their error and meets both ends", "[worlds]") {
  const double radius = GENERATE(0.2, 4.5, 80.0);
  const std::vector<Vec2> points = curved::arc({0, 1}, radius, -0.4, 2.9);
  CHECK((points.front() - Vec2(radius * std::cos(-0.4), 1 + radius * std::sin(-0.4))).norm() < 1e-9);
  CHECK((points.back() - Vec2(radius * std::cos(2.9), 1 + radius * std::sin(2.9))).norm() < 1e-9);
  for (std::size_t k = 1; k < points.size(); ++k) {
    CHECK((points[k] - Vec2(0, 1)).norm() == Approx(radius));
    CHECK(radius - (0.5 * (points[k - 1] + points[k]) - Vec2(0, 1)).norm() <= curved::kChordError + 1e-9);
  }
}

TEST_CASE("a swept profile stands to the left of its way and above it", "[worlds]") {
  MeshBuilder builder;
  const std::array<Vec2, 2> profile{Vec2(2, 0), Vec2(2, 3)};
  const std::array<curved::Station, 2> stations{curved::Station{{0, 0, 1}, Vec2(0, 1)},
                                                curved::Station{{0, 5, 1}, Vec2(0, 1)}};
  curved::sweep(builder, profile, stations, material::kConcrete);
  const Caster caster(builder.take());
  CHECK(caster.cast({0, 2, 2}, Vec3(-1, 0, 0), 10).range == Approx(2));
  CHECK(std::isinf(caster.cast({0, 2, 2}, Vec3(1, 0, 0), 10).range));
  CHECK(std::isinf(caster.cast({0, 2, 0.9}, Vec3(-1, 0, 0), 10).range));
}

TEST_CASE("a leaning bar is round and closed", "[worlds]") {
  MeshBuilder builder;
  const Vec3 from(0, 0, 0), to(1, 0.5, 4), axis = (to - from).normalized();
  curved::add_bar(builder, from, to, 0.2, material::kWood);
  const Caster caster(builder.take());
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u), middle = 0.5 * (from + to);
  for (double angle = 0; angle < 2 * kPi; angle += 0.05) {
    const Vec3 out = std::cos(angle) * u + std::sin(angle) * v;
    CHECK(caster.cast(middle + 2 * out, -out, 5).range == Approx(1.8).margin(kPromised));
  }
  CHECK(caster.cast(to + axis, -axis, 5).range == Approx(1));
}

TEST_CASE("a walk over a flight rises by its height, between its steps and never by more than one off them",
          "[worlds]") {
  const Flight flight;
  Ground ground;
  add_ramps(ground, flight, 0, 3);
  CHECK(ground.height(2, 7) == 0);
  CHECK(ground.height(3 + flight.length() + 1, 0) == Approx(flight.height()));
  double before = 0;
  for (double x = 2; x < 3 + flight.length() + 1; x += 0.01) {
    const double z = ground.height(x, 0);
    const double step =
        flight.rise * std::clamp(std::floor((x - 3) / flight.tread) + 1, 0.0, static_cast<double>(flight.steps));
    CHECK(z >= before - 1e-12);
    CHECK(std::abs(z - step) < flight.rise);
    before = z;
  }
}
