// Planes that revise themselves: rooms seen from poses that drift, what has settled, and what is of no plane. (eqs.
// MAP-12, MAP-13)
#include <catch2/catch.hpp>
#include <cmath>

#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr TimeNs kPeriod = 100'000'000;  // of an insertion [ns]

/// Points on the walls of a room of 8 x 6 x 3 m, as a sensor sees them that moves along it.
class Room {
 public:
  explicit Room(std::uint64_t seed) : uniform_(seed) {}
  /// Insertion `i`, as placed by a pose that is off by `error`: p_W of a true p is error p.
  std::vector<WorldPoint> seen(int i, const Pose& error, int count = 3000) {
    const Vec3 sensor = place(i);
    std::vector<WorldPoint> points;
    for (int k = 0; k < count; ++k) {
      const Vec3 p = on_wall(k % 6);
      WorldPoint point = at(error * (p + uniform_.in_box(Vec3::Zero(), 0.01)));
      point.t = i * kPeriod + k;
      point.range = static_cast<float>((p - sensor).norm());
      point.view = PackedDirection((p - sensor).cast<float>());
      points.push_back(point);
    }
    return points;
  }
  static Vec3 place(int i) { return {-1.5 + 0.05 * i, 0.3 * std::sin(0.3 * i), 0}; }
  /// Root mean square of the distances of true places of walls from the planes of the map [m].
  double error(const Map& map) {
    std::vector<Vec3> queries;
    for (int k = 0; k < 3000; ++k) queries.push_back(on_wall(k % 6));
    std::vector<Surface> found(queries.size());
    map.surfaces(queries, {}, found);
    double squares = 0, count = 0;
    for (std::size_t k = 0; k < queries.size(); ++k) {
      // Where walls meet, a voxel has parts of both.
      if (!found[k].valid || found[k].normal.cwiseAbs().maxCoeff() < 0.99) continue;
      squares += std::pow(found[k].normal.dot(queries[k] - found[k].anchor), 2);
      count += 1;
    }
    REQUIRE(count > 1500);
    return std::sqrt(squares / count);
  }

 private:
  Vec3 on_wall(int wall) {
    Vec3 p = uniform_.in_box(Vec3::Zero(), 1.0).cwiseProduct(Vec3(4, 3, 1.5));
    const int axis = wall / 2;
    p[axis] = (wall % 2 == 0 ? 1.0 : -1.0) * (axis == 0 ? 4.0 : axis == 1 ? 3.0 : 1.5);
    return p;
  }
  Uniform uniform_;
};

/// Errors of poses that grow step by step; none at first.
std::vector<Pose> drift(int count, double angle, double distance) {
  Uniform uniform(11);
  std::vector<Pose> out(1);
  for (int i = 1; i < count; ++i) {
    Vec6 step;
    step << uniform.in_box(Vec3::Zero(), angle), uniform.in_box(Vec3::Zero(), distance);
    out.push_back(out.back().moved(step));
  }
  return out;
}

const std::string kLoose = "thickness: 0.05, drift_deg: 1, drift: 0.1, plane_sigma: 0.003, kernel: 0.05";

std::string bundle(const std::string& more) { return "{type: bundle_planes, " + kLoose + ", " + more + "}"; }

}  // namespace

TEST_CASE("bundle_planes: walls seen from poses that drift come to where the first pose saw them") {  // eq. MAP-12
  EveryMap fixture;
  const std::vector<Pose> errors = drift(30, 0.002, 0.005);
  const std::string grids = GENERATE("1", "2");
  CAPTURE(grids);
  const auto fixed = fixture.make(bundle("iterations: 0, lag: 5, grids: " + grids));
  const auto revised = fixture.make(bundle("iterations: 5, lag: 5, grids: " + grids));
  Room room(1);
  for (int i = 0; i < 30; ++i) {
    const auto points = room.seen(i, errors[static_cast<std::size_t>(i)]);
    const auto stamp = static_cast<std::uint32_t>(i + 1);
    CHECK(fixed->insert(points, stamp).inserted == revised->insert(points, stamp).inserted);
  }
  const auto exact = fixture.make(bundle("iterations: 0, lag: 5, grids: " + grids));
  for (int i = 0; i < 30; ++i) exact->insert(room.seen(i, {}), static_cast<std::uint32_t>(i + 1));
  const double noise = room.error(*exact), before = room.error(*fixed), after = room.error(*revised);
  CHECK(before > 2.0 * noise);
  CHECK(after < 1.4 * noise);
}

TEST_CASE("bundle_planes: what has settled stays, and holds what comes after it") {  // eq. MAP-13
  EveryMap fixture;
  // Six tenths of a second settle; then all poses are off by the same, which increments cannot tell.
  // Voxels stay open, so that points that are not moved back would shift their planes.
  const auto error_of = [&](const char* iterations) {
    const auto map = fixture.make(bundle(std::string(iterations) + ", lag: 0.4, max_points: 100000, keyframe: 0.1"));
    Room room(2);
    for (int i = 0; i < 10; ++i) map->insert(room.seen(i, {}, 6000), static_cast<std::uint32_t>(i + 1));
    const double before = room.error(*map);
    CHECK(before < 0.008);
    Pose off;
    off.p = Vec3(0.02, -0.02, 0.01);
    for (int i = 10; i < 20; ++i) map->insert(room.seen(i, off, 6000), static_cast<std::uint32_t>(i + 1));
    return room.error(*map) - before;
  };
  CHECK(error_of("iterations: 5") < 0.001);
  CHECK(error_of("iterations: 0") > 0.003);
}

TEST_CASE("bundle_planes: a body that passes a wall does not drag the poses along") {  // eq. MAP-12
  EveryMap fixture;
  const auto map = fixture.make(bundle("iterations: 5, lag: 3"));
  Room room(3);
  for (int i = 0; i < 20; ++i) {
    auto points = room.seen(i, {});
    if (i >= 10) {
      // The lower half of one wall is hidden by something that stands 0.2 m before it.
      for (WorldPoint& point : points)
        if (point.p_W.x() > 3.9 && point.p_W.z() < 0) point.p_W.x() -= 0.2;
    }
    map->insert(points, static_cast<std::uint32_t>(i + 1));
  }
  CHECK(room.error(*map) < 0.008);
}

TEST_CASE("bundle_planes: without revision a plane is that of all its points") {
  EveryMap fixture;
  const auto map = fixture.make("{type: bundle_planes, voxel: 1, iterations: 0, min_points: 4, keyframe_points: 1000}");
  Uniform uniform(4);
  std::vector<WorldPoint> points;
  Vec3 mean = Vec3::Zero();
  const Vec3 corner = -Vec3(0.137, 0.223, 0.311);
  for (int i = 0; i < 100; ++i) {
    points.push_back(at(corner + Vec3(uniform(0, 1), uniform(0, 1), 0.3 + uniform(-0.02, 0.02))));
    points.back().t = i * kPeriod;
    mean += points.back().p_W / 100.0;
    map->insert({&points.back(), 1}, 1);
  }
  std::vector<Surface> found(1);
  map->surfaces(std::vector<Vec3>{corner + Vec3(0.5, 0.5, 0.3)}, {}, found);
  REQUIRE(found[0].valid);
  // It is fitted again at each tenth more points.
  CHECK((found[0].anchor - mean).norm() < 0.03);
  CHECK(found[0].normal.cwiseAbs().z() > 0.999);
}

TEST_CASE("bundle_planes: a voxel takes no more points of a keyframe than it should") {
  EveryMap fixture;
  const auto map = fixture.make("{type: bundle_planes, voxel: 10, keyframe_points: 50}");
  Uniform uniform(5);
  std::vector<WorldPoint> points;
  for (int i = 0; i < 200; ++i) points.push_back(at(Vec3(5, 5, 5) + uniform.in_box(Vec3::Zero(), 0.4)));
  CHECK(map->insert(points, 1).inserted == 50);
}

TEST_CASE("bundle_planes: standing still takes no more memory than the lag does") {
  EveryMap fixture;
  const auto map = fixture.make(bundle("lag: 1, keyframe: 0.1"));
  Room room(6);
  std::size_t after_lag = 0;
  for (int i = 0; i < 60; ++i) {
    auto points = room.seen(0, {}, 2000);
    for (WorldPoint& point : points) point.t += i * kPeriod;
    map->insert(points, static_cast<std::uint32_t>(i + 1));
    if (i == 20) after_lag = map->memory_bytes();
  }
  CHECK(map->memory_bytes() < after_lag + after_lag / 10);
}

TEST_CASE("bundle_planes: time that goes back, gaps and a new start leave a map that goes on") {
  EveryMap fixture;
  const auto map = fixture.make(bundle("lag: 1, keyframe: 0.1"));
  Room room(7);
  std::uint32_t stamp = 0;
  for (const int i : {5, 6, 7, 2, 3, 100, 101, 102}) {
    auto points = room.seen(i % 10, {});
    for (std::size_t k = 0; k < points.size(); ++k) points[k].t = i * kPeriod + static_cast<TimeNs>(k);
    map->insert(points, ++stamp);
  }
  CHECK(room.error(*map) < 0.008);
  map->clear();
  CHECK(map->size() == 0);
  for (int i = 0; i < 5; ++i) map->insert(room.seen(i, {}), ++stamp);
  CHECK(room.error(*map) < 0.008);
}

TEST_CASE("bundle_planes: revised planes have the same bits for any number of threads") {
  EveryMap fixture;
  const std::vector<Pose> errors = drift(8, 0.002, 0.005);
  std::vector<std::vector<Surface>> found;
  for (const int threads : {1, 4}) {
    exec::Executor executor(threads);
    const auto map = fixture.make(bundle("grids: 2, lag: 0.5, max_points: 50"), executor);
    Room room(8);
    std::vector<Vec3> queries;
    for (int i = 0; i < 8; ++i) {
      const auto points = room.seen(i, errors[static_cast<std::size_t>(i)]);
      map->insert(points, static_cast<std::uint32_t>(i + 1));
      for (const WorldPoint& point : points) queries.push_back(point.p_W);
    }
    found.emplace_back(queries.size());
    map->surfaces(queries, {}, found.back());
  }
  std::size_t valid = 0;
  for (std::size_t k = 0; k < found[0].size(); ++k) {
    REQUIRE(found[0][k].valid == found[1][k].valid);
    REQUIRE(found[0][k].anchor == found[1][k].anchor);
    REQUIRE(found[0][k].normal == found[1][k].normal);
    valid += found[0][k].valid ? 1U : 0U;
  }
  CHECK(valid > 10000);
}

TEST_CASE("bundle_planes refuses a window that is too long for its keyframes") {
  EveryMap fixture;
  CHECK_THROWS_WITH(fixture.make("{type: bundle_planes, lag: 10, keyframe: 0.1}"), Catch::Contains("64 keyframes"));
}
