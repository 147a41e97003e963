/// Surfaces that are not flat.

#include <catch2/catch.hpp>
#include <cmath>

#include "mesh/roughness.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// Standard deviation of the displacement over a wall of 40 m by 40 m, aslant to the axes.
double deviation(const Roughness& roughness, std::uint8_t material) {
  double sum = 0, squares = 0;
  int count = 0;
  for (double y = 0; y < 40; y += 0.1937) {
    for (double z = 0; z < 40; z += 0.2113) {
      const double d = roughness.displacement({7.3 + 0.37 * y, y, z}, material);
      sum += d;
      squares += d * d;
      ++count;
    }
  }
  const double mean = sum / count;
  return std::sqrt(squares / count - mean * mean);
}

}  // namespace

TEST_CASE("each material has the roughness that it states", "[realism]") {
  const Roughness roughness({.unevenness = 1, .relief = 1}, 5);
  for (const std::uint8_t material :
       {material::kPlaster, material::kBrick, material::kAsphalt, material::kGrass, material::kWood}) {
    CAPTURE(static_cast<int>(material));
    const MaterialRoughness stated = roughness_of(material);
    CHECK(deviation(roughness, material) == Approx(std::hypot(stated.unevenness, stated.relief)).epsilon(0.12));
  }
  CHECK(deviation(Roughness({.unevenness = 2, .relief = 0}, 5), material::kPlaster) == Approx(0.006).epsilon(0.12));
}

TEST_CASE("the displacement is smooth, and the same from wherever a place is seen", "[realism]") {
  const Roughness roughness({.unevenness = 1, .relief = 1}, 9);
  double largest = 0;
  for (double y = 0; y < 10; y += 1e-3)
    largest = std::max(largest, std::abs(roughness.displacement({1.1, y + 1e-4, 0.7}, material::kBrick) -
                                         roughness.displacement({1.1, y, 0.7}, material::kBrick)));
  CHECK(largest < 1e-4);
  // Head on and at 45 deg, from both sides.
  const Vec3 place(2, 3, 1);
  const double d = roughness.displacement(place, material::kBrick);
  REQUIRE(std::abs(d) > 1e-4);
  for (const Vec3& from : {Vec3(0, 3, 1), Vec3(0, 1, 1), Vec3(4, 3, 1)}) {
    const Vec3 direction = (place - from).normalized();
    SurfaceHit hit{.range = (place - from).norm(), .cos_incidence = std::abs(direction.x())};
    hit.material = material::kBrick;
    hit.normal = Vec3::UnitX();
    roughness.apply(from, direction, hit);
    CHECK((from + hit.range * direction).x() == Approx(2 + d).margin(1e-12));
  }
}

TEST_CASE("without roughness, and for those who move, a hit stays as it is", "[realism]") {
  SurfaceHit hit{.range = 5, .cos_incidence = 0.5};
  hit.material = material::kGrass;
  Roughness({}, 1).apply(Vec3::Zero(), Vec3::UnitX(), hit);
  CHECK(hit.range == 5);
  hit.moving = true;
  Roughness({.unevenness = 1, .relief = 1}, 1).apply(Vec3::Zero(), Vec3::UnitX(), hit);
  CHECK(hit.range == 5);
  SurfaceHit none;
  Roughness({.unevenness = 1, .relief = 1}, 1).apply(Vec3::Zero(), Vec3::UnitX(), none);
  CHECK(std::isinf(none.range));
}
