#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/simulator/boxes.hpp"
#include "aslio/simulator/random.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

bool inside(const Box& box, const Vec3& p) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  const Vec3 d = p - box.centre;
  return std::abs(c * d.x() + s * d.y()) <= box.half.x() && std::abs(c * d.y() - s * d.x()) <= box.half.y() &&
         std::abs(d.z()) <= box.half.z();
}

/// First range at which a step along the ray is inside a box.
double march(const std::vector<Box>& boxes, const Vec3& o, const Vec3& d, double step, double limit) {
  for (double r = 0; r < limit; r += step)
    for (const Box& box : boxes)
      if (inside(box, o + r * d)) return r;
  return limit;
}

}  // namespace

TEST_CASE("rays meet boxes where marching along them does") {
  RandomStream random(5, 0);
  const auto anywhere = [&](double bound) {
    const double x = random.uniform(-bound, bound), y = random.uniform(-bound, bound);
    return Vec3(x, y, random.uniform(-bound, bound));
  };
  int hits = 0;
  for (int trial = 0; trial < 150; ++trial) {
    std::vector<Box> boxes;
    for (int i = 0; i < 6; ++i) {
      const Vec3 half = anywhere(0.8).cwiseAbs() + Vec3::Constant(0.1);
      boxes.push_back({anywhere(4), half, i % 2 == 0 ? 0 : random.uniform(-3, 3), 0.1 * i});
    }
    // Two of three rays are aimed somewhere near a box.
    const Vec3 origin = anywhere(5);
    const Vec3 aim = trial % 3 == 0 ? anywhere(5) : Vec3(boxes[0].centre + anywhere(0.7));
    const Vec3 direction = (aim - origin).normalized();
    const BoxScene scene(boxes);
    if (scene.clearance(origin) == 0) continue;
    const Hit hit = scene.cast(origin, direction);
    const double expected = march(boxes, origin, direction, 1e-3, 12);
    if (hit.solid < 0 || hit.range > 11.9) {
      CHECK(expected > 11.8);
      continue;
    }
    ++hits;
    // Marching may step over a corner, never find one that is not there.
    CHECK(hit.range <= expected + 1e-9);
    const Box& box = boxes[static_cast<std::size_t>(hit.solid)];
    CHECK(inside(Box{box.centre, box.half + Vec3::Constant(1e-9), box.yaw, 0}, origin + hit.range * direction));
    if (expected < 12) CHECK(hit.range > expected - 0.05);
    CHECK(hit.reflectivity == box.reflectivity);
  }
  CHECK(hits > 30);
}

TEST_CASE("a wall is hit at its distance, at any incidence and along the axes") {
  const BoxScene scene({box_between({2, -50, -50}, {3, 50, 50}, 0.7)});
  for (double angle = -1.4; angle <= 1.4; angle += 0.1) {
    const Hit hit = scene.cast(Vec3::Zero(), Vec3(std::cos(angle), std::sin(angle), 0));
    CHECK(hit.range == Approx(2 / std::cos(angle)));
    CHECK(hit.cos_incidence == Approx(std::cos(angle)));
    CHECK(hit.reflectivity == 0.7);
    CHECK(hit.solid == 0);
  }
  CHECK(scene.cast(Vec3::Zero(), -Vec3::UnitX()).solid == -1);
  CHECK(scene.cast(Vec3::Zero(), Vec3::UnitZ()).solid == -1);
  CHECK(scene.clearance(Vec3::Zero()) == Approx(2));
  CHECK(scene.clearance(Vec3(2.5, 0, 0)) == 0);
}

TEST_CASE("a turned box shows its corner, and a moving box hides what is behind it") {
  const Box turned{{5, 0, 0}, {1, 1, 1}, std::numbers::pi / 4, 0.5};
  const BoxScene scene({turned});
  const Hit hit = scene.cast(Vec3(0, 0.1, 0), Vec3::UnitX());
  CHECK(hit.range == Approx(5 - std::sqrt(2) + 0.1));
  CHECK(hit.cos_incidence == Approx(std::sqrt(0.5)));
  const Box person{{2, 0, 0}, {0.2, 0.3, 1}, 0, 0.25};
  const Hit hidden = scene.cast(Vec3(0, 0.1, 0), Vec3::UnitX(), {&person, 1});
  CHECK(hidden.range == Approx(1.8));
  CHECK(hidden.solid == 1);
  CHECK(scene.cast(Vec3(0, 0.5, 0), Vec3::UnitX(), {&person, 1}).solid == 0);
}
