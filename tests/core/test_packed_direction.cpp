#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "aslio/core/packed_direction.hpp"

using aslio::PackedDirection;
using Eigen::Vector3f;

TEST_CASE("a packed direction is within 1 deg of what it was made from, of any length") {
  std::mt19937 engine(1);
  std::normal_distribution<float> normal;
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vector3f v(normal(engine), normal(engine), normal(engine));
    const Vector3f unit = PackedDirection((i % 2 == 0 ? 1e-3F : 1e3F) * v).vector();
    REQUIRE(std::abs(unit.norm() - 1) < 1e-6F);
    worst = std::max(worst, static_cast<double>((unit - v.normalized()).norm()));
    const Vector3f toward = PackedDirection(v).toward();
    REQUIRE((toward.norm() > 70 && toward.norm() <= 127));
    REQUIRE(toward.normalized() == PackedDirection(v).vector());
  }
  CHECK(worst < M_PI / 180);
  CHECK(worst > 0.002);  // it is packed
}

TEST_CASE("a packed direction along an axis is exact") {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0F, -1.0F}) {
      const Vector3f v = sign * Vector3f::Unit(axis);
      CHECK((PackedDirection(5 * v).vector() - v).norm() < 1e-6F);
    }
  }
}

TEST_CASE("no direction stays none") {
  CHECK(sizeof(PackedDirection) == 2);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const Vector3f& v : {Vector3f(0, 0, 0), Vector3f(nan, 1, 0), Vector3f(inf, 0, 0)}) {
    CHECK(PackedDirection(v).none());
    CHECK(PackedDirection(v).vector() == Vector3f::Zero());
    CHECK(PackedDirection(v).toward() == Vector3f::Zero());
  }
  CHECK(PackedDirection().none());
  CHECK_FALSE(PackedDirection(Vector3f(-1, 0, 0)).none());
}
