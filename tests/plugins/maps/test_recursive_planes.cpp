// Planes among the points of a voxel, the rest handed on; planes that are seen through. (eq. MAP-9)
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "maps/recursive_planes.hpp"
#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

const Vec3 kDown(0, 0, -1), kUp(0, 0, 1), kNoView(0, 0, 0);

/// One voxel of 1 m, whose corner is the origin of all coordinates.
struct Voxel {
  explicit Voxel(const std::string& keys = "")
      : map(fixture.make("{type: recursive_planes, voxel: 1.0, levels: 2" + keys + "}")) {}

  WorldPoint seen(const Vec3& p, const Vec3& view) const {
    WorldPoint point = at(corner + p);
    point.view = PackedDirection(view.cast<float>());
    return point;
  }
  /// Points of z = height over [low, high] x [0, 1], seen in the direction `view`.
  std::size_t floor(double low, double high, double height, int count, const Vec3& view = kDown,
                    std::uint32_t stamp = 1) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < count; ++i)
      points.push_back(seen({uniform(low, high), uniform(0, 1), height + uniform(-0.01, 0.01)}, view));
    return map->insert(points, stamp).inserted;
  }
  Surface at_point(const Vec3& p, const std::optional<Vec3>& from = {}, std::uint32_t max_stamp = 0xffffffff) {
    MapQuery query;
    query.max_stamp = max_stamp;
    if (from) query.viewpoint = corner + *from;
    std::vector<Surface> found(1);
    map->surfaces(std::vector<Vec3>{corner + p}, query, found);
    found[0].anchor -= corner;
    return found[0];
  }
  /// Height of the plane at p; NaN without one.
  double height(const Vec3& p, const std::optional<Vec3>& from = {}) {
    const Surface found = at_point(p, from);
    return found.valid ? found.anchor.z() : std::nan("");
  }
  std::uint64_t reopened() const { return dynamic_cast<plugins::RecursivePlanes&>(*map).reopened(); }

  Vec3 corner = -Vec3(0.137, 0.223, 0.311);
  EveryMap fixture;
  Uniform uniform{1};
  std::unique_ptr<Map> map;
};

}  // namespace

TEST_CASE("recursive_planes: two surfaces of one voxel are two planes") {
  Voxel voxel;
  for (int i = 0; i < 20; ++i) {
    voxel.floor(0.0, 1.0, 0.2, 20);
    voxel.floor(0.0, 0.5, 0.7, 10);  // a box on the floor
  }
  CHECK(voxel.height({0.75, 0.5, 0.2}) == Approx(0.2).margin(0.005));
  CHECK(voxel.height({0.25, 0.5, 0.2}) == Approx(0.2).margin(0.005));
  CHECK(voxel.height({0.25, 0.25, 0.7}) == Approx(0.7).margin(0.005));
}

TEST_CASE("recursive_planes: a third of the points on no surface does not hide the plane") {
  Voxel voxel;
  std::vector<WorldPoint> points;
  for (int i = 0; i < 300; ++i) {
    const double z = i % 3 == 0 ? voxel.uniform(0, 1) : 0.4 + voxel.uniform(-0.01, 0.01);
    points.push_back(voxel.seen({voxel.uniform(0, 1), voxel.uniform(0, 1), z}, kDown));
  }
  voxel.map->insert(points, 1);
  const Surface found = voxel.at_point({0.5, 0.5, 0.4});
  REQUIRE(found.valid);
  CHECK(found.anchor.z() == Approx(0.4).margin(0.01));
  CHECK(std::abs(found.normal.z()) > 0.999);
}

TEST_CASE("recursive_planes: the faces of a wall of 4 cm are two planes, each met from its side") {
  Voxel voxel;
  voxel.floor(0, 1, 0.70, 300, kDown);
  voxel.floor(0, 1, 0.66, 300, kUp);
  CHECK(voxel.height({0.25, 0.25, 0.68}, Vec3(0.25, 0.25, 5)) == Approx(0.70).margin(0.005));
  CHECK(voxel.height({0.25, 0.25, 0.68}, Vec3(0.25, 0.25, -5)) == Approx(0.66).margin(0.005));
}

TEST_CASE("recursive_planes: a plane that points are seen through is forgotten, unless `reopen` is 0") {
  for (const bool forgets : {true, false}) {
    CAPTURE(forgets);
    Voxel voxel(forgets ? ", reopen: 30" : ", reopen: 0");
    voxel.floor(0, 1, 0.6, 40);  // a door, or a wall placed wrongly
    REQUIRE(voxel.height({0.5, 0.5, 0.6}) == Approx(0.6).margin(0.005));
    voxel.floor(0, 1, 0.2, 400);
    CHECK(voxel.reopened() == (forgets ? 1 : 0));
    CHECK(voxel.height({0.5, 0.5, 0.58}) == Approx(forgets ? 0.2 : 0.6).margin(0.005));
    // What is behind was kept by the voxels below in any case.
    CHECK(voxel.height({0.25, 0.25, 0.2}) == Approx(0.2).margin(0.005));
  }
}

TEST_CASE("recursive_planes: points before a plane, beside its points, or without a view, do not tell against it") {
  Voxel voxel(", reopen: 10");
  voxel.floor(0.0, 0.4, 0.4, 40);
  SECTION("before it") { voxel.floor(0.0, 0.4, 0.9, 500); }
  SECTION("beside it") { voxel.floor(0.8, 1.0, 0.1, 500); }
  SECTION("without a view") { voxel.floor(0.0, 0.4, 0.1, 500, kNoView); }
  SECTION("seen along it") { voxel.floor(0.0, 0.4, 0.1, 500, Vec3(1, 0, -0.05)); }
  SECTION("while as many lie on it") {
    for (int i = 0; i < 100; ++i) {
      voxel.floor(0.0, 0.4, 0.4, 6);
      voxel.floor(0.0, 0.4, 0.1, 5);
    }
  }
  CHECK(voxel.reopened() == 0);
  CHECK(voxel.height({0.2, 0.5, 0.4}) == Approx(0.4).margin(0.005));
}

TEST_CASE("recursive_planes: a plane takes max_points, and counts from the update that found it") {
  Voxel voxel(", max_points: 100");
  CHECK(voxel.floor(0, 1, 0.2, 100, kDown, 5) == 100);
  const Surface before = voxel.at_point({0.5, 0.5, 0.2});
  REQUIRE(before.valid);
  CHECK(voxel.floor(0, 1, 0.23, 500, kDown, 6) == 0);
  CHECK(voxel.at_point({0.5, 0.5, 0.2}).anchor == before.anchor);
  CHECK(voxel.at_point({0.5, 0.5, 0.2}, {}, 5).valid);
  CHECK_FALSE(voxel.at_point({0.5, 0.5, 0.2}, {}, 4).valid);
}

TEST_CASE("recursive_planes: a cloud of points is no plane, and its voxels stop to look for one") {
  Voxel voxel;
  std::vector<WorldPoint> points;
  for (int i = 0; i < 20000; ++i)
    points.push_back(voxel.seen({voxel.uniform(0, 1), voxel.uniform(0, 1), voxel.uniform(0, 1)}, kDown));
  voxel.map->insert(points, 1);
  CHECK_FALSE(voxel.at_point({0.5, 0.5, 0.5}).valid);
  CHECK(voxel.map->insert(points, 2).inserted == 0);
}

TEST_CASE("recursive_planes: what is trimmed is forgotten, and its memory used again") {
  Voxel voxel(", radius: 5");
  voxel.floor(0, 1, 0.2, 40);
  voxel.floor(0, 0.5, 0.7, 400);
  const std::size_t bytes = voxel.map->memory_bytes();
  for (int i = 0; i < 50; ++i) {
    voxel.map->trim(Vec3(100.0 * (i + 1), 0, 0));
    CHECK(voxel.map->size() == 0);
    voxel.corner += Vec3(100, 0, 0);
    voxel.floor(0, 1, 0.2, 40);
    voxel.floor(0, 0.5, 0.7, 400);
    CHECK(voxel.height({0.25, 0.5, 0.7}) == Approx(0.7).margin(0.005));
  }
  CHECK(voxel.map->memory_bytes() <= 2 * bytes);
}

TEST_CASE("recursive_planes: thickness grows with the noise") {
  Voxel voxel(", thickness: 0.004");
  voxel.floor(0, 1, 0.2, 60);
  CHECK_FALSE(voxel.at_point({0.5, 0.5, 0.2}).valid);
  Voxel noisy(", thickness: 0.004");
  noisy.map->set_noise_scale(3);
  noisy.floor(0, 1, 0.2, 60);
  CHECK(noisy.at_point({0.5, 0.5, 0.2}).valid);
  // eq. NOI-2: what was too thick begins again.
  voxel.floor(0, 1, 0.2, 400);
  voxel.map->set_noise_scale(3);
  voxel.floor(0, 1, 0.2, 60);
  CHECK(voxel.at_point({0.5, 0.5, 0.2}).valid);
}

TEST_CASE("recursive_planes: a voxel no more than six times as wide as the noise is a plane once the noise is known") {
  for (const double scale : {1.0, 2.5}) {
    CAPTURE(scale);
    EveryMap fixture;
    const auto map = fixture.make("{type: recursive_planes, voxel: 0.3, levels: 1, thickness: 0.025}");
    map->set_noise_scale(scale);
    Uniform uniform(2);
    std::vector<WorldPoint> points;
    const Vec3 corner = -0.3 * Vec3(0.137, 0.223, 0.311);
    for (int i = 0; i < 300; ++i)
      points.push_back(at(corner + Vec3(uniform(0, 0.3), uniform(0, 0.3), 0.15 + uniform(-0.07, 0.07))));
    map->insert(points, 1);
    std::vector<Surface> found(1);
    map->surfaces(std::vector<Vec3>{corner + Vec3(0.15, 0.15, 0.15)}, MapQuery{}, found);
    CHECK(found[0].valid == (scale > 1));
  }
}
