// What every registered map of surfaces promises (stages/map.hpp), with its default parameters.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>

#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Points of a square of edge 2 * half about `centre`, `noise` [m] either way from it along the normal.
std::vector<WorldPoint> square(Uniform& uniform, const Vec3& centre, const Vec3& normal, double half, double noise,
                               int count) {
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  std::vector<WorldPoint> points;
  for (int i = 0; i < count; ++i) {
    const double a = uniform(-half, half), b = uniform(-half, half), c = uniform(-noise, noise);
    points.push_back(at(centre + a * first + b * second + c * normal));
  }
  return points;
}

std::vector<Surface> ask(const Map& map, const std::vector<Vec3>& queries, std::uint32_t max_stamp = 0xffffffff) {
  std::vector<Surface> found(queries.size());
  MapQuery query;
  query.max_stamp = max_stamp;
  map.surfaces(queries, query, found);
  return found;
}

bool same(const Surface& a, const Surface& b) {
  return a.valid == b.valid && a.normal == b.normal && a.anchor == b.anchor && a.quality == b.quality &&
         (a.owner == nullptr) == (b.owner == nullptr);
}

}  // namespace

TEST_CASE("every map of surfaces: planes are found where they are, near and far from the origin") {
  EveryMap fixture;
  const auto types = fixture.types(MapContent::surfaces);
  REQUIRE((!types.empty() || one_under_test(Map::family)));
  for (const auto& type : types) {
    for (const double origin : {0.0, 1e5}) {
      for (const Vec3& n : {Vec3(0, 0, 1), Vec3(0.6, -0.8, 0), Vec3(0.2, 0.5, -0.7)}) {
        INFO(type << " at " << origin << ", normal " << n.transpose());
        const auto map = fixture.make(type);
        // Off the faces of voxels, which would cut the noise in two.
        const Vec3 centre(origin + 0.1, -origin, 0.1 * origin + 0.13), normal = n.normalized();
        Uniform uniform(5);
        // 0.02 m either way is a deviation of 0.0115 m; a voxel of 0.25 m holds 200 of the 800 points/m^2 and more.
        map->insert(square(uniform, centre, normal, 2.0, 0.02, 51200), 1);
        std::vector<Vec3> queries;
        for (const WorldPoint& p : square(uniform, centre, normal, 1.5, 0.0, 500)) queries.push_back(p.p_W);
        std::size_t valid = 0, good = 0;
        const auto found = ask(*map, queries);
        for (std::size_t i = 0; i < queries.size(); ++i) {
          if (!found[i].valid) continue;
          ++valid;
          REQUIRE(std::abs(found[i].normal.norm() - 1.0) < 1e-9);
          REQUIRE(found[i].quality > 0.0);
          REQUIRE(found[i].quality <= 1.0);
          if (type.find("_plane") != std::string::npos) REQUIRE(found[i].owner != nullptr);
          // Who is told to share a surface does: and all who share one are told, if any is.
          for (std::size_t j = 0; j < i; ++j) {
            if (!found[j].valid || (found[i].owner == nullptr && found[j].owner == nullptr)) continue;
            const bool one = found[j].normal == found[i].normal && found[j].anchor == found[i].anchor;
            REQUIRE((found[j].owner == found[i].owner) == one);
          }
          // A plane is as good as its quality says: slivers in the corners of voxels are not.
          const double tolerance = 0.01 / found[i].quality;
          CHECK(std::abs(found[i].normal.dot(queries[i] - found[i].anchor)) < tolerance);
          good += found[i].quality > 0.8 && std::abs(found[i].normal.dot(normal)) > std::cos(0.02) ? 1U : 0U;
        }
        CHECK(valid > 450);  // corners of voxels hold little of the plane
        CHECK(good > 400);
      }
    }
  }
}

TEST_CASE("every map of surfaces: nothing is found in empty space, in clutter or along a line, nor among few points") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::surfaces)) {
    INFO(type);
    const auto map = fixture.make(type);
    CHECK(!ask(*map, {{0, 0, 0}})[0].valid);
    Uniform uniform(6);
    std::vector<WorldPoint> points;
    for (int i = 0; i < 20000; ++i) points.push_back(at(uniform.in_box({10, 0, 0}, 1.0)));
    for (int i = 0; i < 4000; ++i) points.push_back(at({20 + uniform(-1, 1), uniform(-1e-3, 1e-3), 0.1}));
    for (int i = 0; i < 3; ++i) points.push_back(at({30 + 0.1 * i, 0.01 * i * i, 0.1}));
    map->insert(points, 1);
    for (int i = 0; i < 200; ++i) {
      CHECK(!ask(*map, {uniform.in_box({10, 0, 0}, 0.9)})[0].valid);
      CHECK(!ask(*map, {{20 + uniform(-0.9, 0.9), 0.0, 0.1}})[0].valid);
    }
    CHECK(!ask(*map, {{30.1, 0.01, 0.1}})[0].valid);
    CHECK(!ask(*map, {{-50, 0, 0}})[0].valid);
  }
}

TEST_CASE("every map of surfaces: only what was there at max_stamp is seen") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::surfaces)) {
    INFO(type);
    const auto map = fixture.make(type);
    Uniform uniform(8);
    map->insert(square(uniform, {0, 0, 0.1}, {0, 0, 1}, 2.0, 0.01, 20000), 3);
    map->insert(square(uniform, {10, 0, 0.1}, {0, 0, 1}, 2.0, 0.01, 20000), 4);
    const std::vector<Vec3> queries{{0.2, 0.2, 0.1}, {10.2, 0.2, 0.1}};
    for (const std::uint32_t stamp : {2U, 3U, 4U}) {
      const auto found = ask(*map, queries, stamp);
      CHECK(found[0].valid == (stamp >= 3));
      CHECK(found[1].valid == (stamp >= 4));
    }
  }
}

TEST_CASE("every map of surfaces: the same bits for any number of threads, and after clear()") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::surfaces)) {
    INFO(type);
    std::vector<Surface> expected;
    for (const int threads : {1, 2, 3, 8}) {
      exec::Executor executor(threads);
      const auto map = fixture.make(type, executor);
      for (int life = 0; life < 2; ++life) {
        Uniform uniform(3);
        for (std::uint32_t stamp = 1; stamp <= 10; ++stamp) {
          map->insert(square(uniform, {0, 0, 0.1}, {0, 0.1, 1}, 3.0, 0.02, 3000), stamp);
          map->insert(square(uniform, {1, 0, 0.1}, {1, 0.1, 0}, 3.0, 0.02, 3000), stamp);
        }
        std::vector<Vec3> queries;
        for (int i = 0; i < 3000; ++i) queries.push_back(uniform.in_box(Vec3::Zero(), 3.5));
        const auto found = ask(*map, queries);
        if (expected.empty()) expected = found;
        REQUIRE(std::any_of(found.begin(), found.end(), [](const Surface& s) { return s.valid; }));
        for (std::size_t i = 0; i < queries.size(); ++i) REQUIRE(same(found[i], expected[i]));
        map->clear();
        REQUIRE(map->size() == 0);
        for (const Surface& surface : ask(*map, queries)) REQUIRE(!surface.valid);
      }
    }
  }
}

TEST_CASE("every map of surfaces: no surface is found at what is not finite or beyond all cells") {
  EveryMap fixture;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto& type : fixture.types(MapContent::surfaces)) {
    INFO(type);
    const auto map = fixture.make(type);
    Uniform uniform(9);
    map->insert(square(uniform, {0, 0, 0.1}, {0, 0, 1}, 2.0, 0.01, 20000), 1);
    for (const Vec3& p : {Vec3(nan, 0, 0), Vec3(0, inf, 0), Vec3(0, 0, -inf), Vec3(1e30, 0, 0), Vec3(0, -1e300, 0)}) {
      CHECK(!ask(*map, {p})[0].valid);
    }
  }
}
