#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <thread>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/boxes.hpp"
#include "aslio/simulator/caster.hpp"
#include "simulator/mesh/rays.hpp"

using namespace aslio;
using namespace aslio::simulator;
using aslio::test::any_direction;
using aslio::test::in_cube;

namespace {

constexpr double kFar = 1000;

std::vector<Box> random_boxes(RandomStream& random, int n) {
  std::vector<Box> boxes;
  for (int i = 0; i < n; ++i) {
    Box box;
    box.centre = in_cube(random, 12);
    box.half = in_cube(random, 1.5).cwiseAbs() + Vec3::Constant(0.2);
    box.yaw = i % 3 == 0 ? 0 : random.uniform(-3, 3);
    box.reflectivity = static_cast<double>(1 + i % 200) / 255;
    boxes.push_back(box);
  }
  return boxes;
}

Mesh mesh_of(const std::vector<Box>& boxes) {
  MeshBuilder builder;
  for (const Box& box : boxes) {
    const auto placed = builder.place({box.centre, box.yaw});
    builder.box(-box.half, box.half, static_cast<std::uint8_t>(std::lround(box.reflectivity * 255)));
  }
  return builder.take();
}

bool same(const SurfaceHit& hit, const Hit& truth) {
  if (truth.solid < 0) return std::isinf(hit.range);
  // Corners are rounded to 1e-6 m; a grazing ray magnifies that.
  return std::abs(hit.range - truth.range) <= 3e-6 / std::max(truth.cos_incidence, 1e-3) &&
         std::abs(hit.cos_incidence - truth.cos_incidence) < 1e-4 &&
         std::abs(hit.reflectivity - truth.reflectivity) < 1e-9;
}

/// Whether a ray turned by 1e-5 rad in some direction meets in closed form what the mesh was said to show.
bool near_edge(const BoxScene& scene, const Vec3& origin, const Vec3& direction, const SurfaceHit& hit) {
  const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
  for (int k = 0; k < 16; ++k) {
    const double angle = k * std::numbers::pi / 8;
    const Vec3 turned = (direction + 1e-5 * (std::cos(angle) * u + std::sin(angle) * v)).normalized();
    const Hit truth = scene.cast(origin, turned);
    if (truth.solid < 0 && std::isinf(hit.range)) return true;
    if (truth.solid >= 0 && std::abs(truth.range - hit.range) < 1e-3) return true;
  }
  return false;
}

struct Firing {
  Vec3 origin;
  std::array<Vec3, 6> directions;
};

/// Six lines 1.4 deg apart that sweep a rosette while the sensor turns.
std::vector<Firing> rosette(std::size_t n, const Vec3& start) {
  std::vector<Firing> firings(n);
  const double deg = std::numbers::pi / 180;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = 25e-6 * static_cast<double>(i), w1 = 763.82589 * t, w2 = -488.41294 * t;
    const double azimuth = 16.9 * deg * (std::cos(w1) + std::cos(w2)) + 3 * t;
    const double elevation = 16.6 * deg * (std::sin(w1) + std::sin(w2));
    firings[i].origin = start + Vec3(0.3 * t, 0.1 * t, 0);
    for (std::size_t line = 0; line < 6; ++line) {
      const double e = elevation + (static_cast<double>(line) - 2) * 1.4 * deg;
      firings[i].directions[line] = {std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e)};
    }
  }
  return firings;
}

/// Rooms with doors and furniture, 60 m by 60 m.
Mesh office() {
  MeshBuilder b;
  RandomStream random(1, 0);
  b.slab({-30, -30}, {30, 30}, 0, 100);
  b.slab({-30, -30}, {30, 30}, 2.8, 200);
  for (int i = 0; i <= 10; ++i) {
    const double p = -30 + 6 * i;
    for (int j = 0; j < 10; ++j) {
      const double q = -30 + 6 * j;
      b.wall({p, q}, {p, q + 2.4}, 0, 2.8, 190);
      b.wall({p, q + 3.6}, {p, q + 6}, 0, 2.8, 190);
      b.wall({q, p}, {q + 2.4, p}, 0, 2.8, 190);
      b.wall({q + 3.6, p}, {q + 6, p}, 0, 2.8, 190);
    }
  }
  while (b.mesh().triangles.size() < 20000) {
    const double x = random.uniform(-29, 29), y = random.uniform(-29, 29), yaw = random.uniform(0, 6);
    if (std::hypot(x, y) < 1.5) continue;
    const auto placed = b.place({{x, y, 0}, yaw});
    b.box({-0.4, -0.2, 0}, {0.4, 0.2, 1.8}, 120);
    b.frustum({0.8, 0, 0}, 0.2, 0.15, 0.9, 16, 100);
  }
  return b.take();
}

std::vector<SurfaceHit> cast_all(const Caster& caster, const std::vector<Firing>& firings, int threads) {
  std::vector<SurfaceHit> hits(6 * firings.size());
  std::vector<std::thread> crew;
  for (int k = 0; k < threads; ++k) {
    crew.emplace_back([&, k] {
      for (std::size_t i = static_cast<std::size_t>(k); i < firings.size(); i += static_cast<std::size_t>(threads))
        caster.cast(firings[i].origin, firings[i].directions, kFar, std::span(hits).subspan(6 * i, 6));
    });
  }
  for (std::thread& one : crew) one.join();
  return hits;
}

bool same_bits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].range != b[i].range || a[i].cos_incidence != b[i].cos_incidence || a[i].reflectivity != b[i].reflectivity)
      return false;
  return a.size() == b.size();
}

}  // namespace

TEST_CASE("rays meet a mesh of boxes where the closed form says") {
  RandomStream random(11, 0);
  int hits = 0, misses = 0, edges = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const std::vector<Box> boxes = random_boxes(random, 120);
    const BoxScene scene(boxes);
    const Caster caster(mesh_of(boxes));
    for (int i = 0; i < 100; ++i) {
      const Vec3 origin = in_cube(random, 15);
      if (scene.clearance(origin) < 0.05) continue;
      std::array<Vec3, 11> directions;
      for (Vec3& d : directions) d = any_direction(random);
      std::array<SurfaceHit, 11> found;
      caster.cast(origin, directions, kFar, found);
      for (std::size_t k = 0; k < directions.size(); ++k) {
        const Hit truth = scene.cast(origin, directions[k]);
        const SurfaceHit alone = caster.cast(origin, directions[k], kFar);
        truth.solid < 0 ? ++misses : ++hits;
        for (const SurfaceHit& hit : {found[k], alone}) {
          if (same(hit, truth)) continue;
          ++edges;
          CHECK(near_edge(scene, origin, directions[k], hit));
        }
        if (truth.solid >= 0 && truth.cos_incidence > 0.05 && same(found[k], truth))
          CHECK(found[k].range == Approx(truth.range).epsilon(1e-4));
      }
    }
  }
  CHECK(hits > 5000);
  CHECK(misses > 5000);
  CHECK(edges < 10);
}

TEST_CASE("a wall at 80 m is flat") {
  const double yaw = GENERATE(0.0, 0.3);
  MeshBuilder builder;
  {
    const auto placed = builder.place({Vec3::Zero(), yaw});
    builder.wall({-150, 80}, {150, 80}, -40, 40, 100);
  }
  const Caster caster(builder.take());
  const Vec3 normal(-std::sin(yaw), std::cos(yaw), 0), along(std::cos(yaw), std::sin(yaw), 0);
  RandomStream random(3, 0);
  double worst = 0, worst_cosine = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 origin(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const Vec3 target = 80 * normal + random.uniform(-149, 149) * along + random.uniform(-39, 39) * Vec3::UnitZ();
    const Vec3 direction = (target - origin).normalized();
    const SurfaceHit hit = caster.cast(origin, direction, kFar);
    worst = std::max(worst, std::abs(normal.dot(origin + hit.range * direction) - 80));
    worst_cosine = std::max(worst_cosine, std::abs(hit.cos_incidence - normal.dot(direction)));
  }
  CHECK(worst < (yaw == 0 ? 1e-11 : 1e-5));  // turned corners are rounded to 4e-6 m
  CHECK(worst_cosine < 1e-6);
}

TEST_CASE("nothing is seen beyond the longest range or where nothing is") {
  MeshBuilder builder;
  builder.wall({-1, 10}, {1, 10}, -1, 1, 51);
  const Caster caster(builder.take());
  const SurfaceHit hit = caster.cast(Vec3::Zero(), Vec3::UnitY(), 10);
  CHECK(hit.range == 10);
  CHECK(hit.cos_incidence == 1);
  CHECK(hit.reflectivity == Approx(0.2));
  CHECK_FALSE(hit.moving);
  CHECK(std::isinf(caster.cast(Vec3::Zero(), Vec3::UnitY(), 9.9999999).range));
  CHECK(std::isinf(caster.cast(Vec3::Zero(), -Vec3::UnitY(), 1000).range));
  CHECK(caster.cast(Vec3::Zero(), Vec3::UnitY(), std::numeric_limits<double>::infinity()).range == 10);
  // From either side.
  CHECK(caster.cast({0, 12, 0}, -Vec3::UnitY(), 100).range == 2);
}

TEST_CASE("a ray along a face ends within it") {
  MeshBuilder builder;
  builder.slab({2, -1}, {4, 1}, 0, 100);
  const Caster caster(builder.take());
  RandomStream random(8, 0);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 direction = Vec3(1, random.uniform(-0.2, 0.2), random.uniform(-1e-9, 1e-9)).normalized();
    const SurfaceHit hit = caster.cast({0, 0, random.uniform(-1e-9, 1e-9)}, direction, 100);
    if (std::isinf(hit.range)) continue;
    ++hits;
    CHECK(hit.range * direction.x() > 2 - 1e-6);
    CHECK(hit.range * direction.x() < 4 + 0.2);
    CHECK(hit.cos_incidence < 1e-6);
  }
  CAPTURE(hits);
}

TEST_CASE("hits are the same from 1 and 4 threads and from a second tree") {
  const std::vector<Firing> firings = rosette(5000, {0.1, 0.2, 1.5});
  const Caster caster(office()), again(office());
  const std::vector<SurfaceHit> hits = cast_all(caster, firings, 1);
  CHECK(same_bits(hits, cast_all(caster, firings, 4)));
  CHECK(same_bits(hits, cast_all(again, firings, 1)));
  int met = 0;
  for (const SurfaceHit& hit : hits) met += std::isfinite(hit.range);
  CHECK(met == 30000);
}

TEST_CASE("packets and single rays see the same surfaces") {
  const std::vector<Firing> firings = rosette(5000, {0.1, 0.2, 1.5});
  const Caster caster(office());
  const std::vector<SurfaceHit> hits = cast_all(caster, firings, 1);
  int different = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const SurfaceHit alone = caster.cast(firings[i / 6].origin, firings[i / 6].directions[i % 6], kFar);
    different += std::abs(alone.range - hits[i].range) > 1e-4;
  }
  CHECK(different <= 3);  // rays on an edge
}

TEST_CASE("casting leaves the rounding of subnormal numbers alone") {
  MeshBuilder builder;
  builder.box({1, -1, -1}, {2, 1, 1}, 100);
  const Caster caster(builder.take());
  CHECK(caster.cast(Vec3::Zero(), Vec3::UnitX(), 10).range == 1);
  volatile double small = std::numeric_limits<double>::min();
  volatile float small_float = std::numeric_limits<float>::min();
  CHECK(small / 2 > 0);
  CHECK(small_float / 2 > 0);
}

TEST_CASE("a mesh without triangles is refused") { CHECK_THROWS_AS(Caster(Mesh{}), ConfigError); }

TEST_CASE("memory and speed of casting") {
  const Caster caster(office());
  const double per_triangle = static_cast<double>(caster.bytes()) / static_cast<double>(caster.mesh().triangles.size());
  CHECK(per_triangle > 50);  // the tree is counted
  CHECK(per_triangle < 200);
  const std::vector<Firing> firings = rosette(50000, {0.1, 0.2, 1.5});
  const auto begin = std::chrono::steady_clock::now();
  double sum = 0;
  for (const Firing& firing : firings) {
    std::array<SurfaceHit, 6> hits;
    caster.cast(firing.origin, firing.directions, kFar, hits);
    sum += hits[0].range;
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  const double rate = 6 * static_cast<double>(firings.size()) / taken.count() / 1e6;
  WARN(per_triangle << " bytes per triangle, " << rate << " M rays/s");
  CHECK(std::isfinite(sum));
  CHECK(rate > 0.3);
}
