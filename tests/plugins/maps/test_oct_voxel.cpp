// Voxels of eight representatives beyond the contract: what is fused, what a query sees, what is forgotten. (eq. MAP-6)
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <tuple>

#include "maps/oct_voxel.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::OctVoxel;

namespace {

using Key = std::array<int, 3>;

Key cell(const Vec3& p, double edge) {
  const Eigen::Vector3i c = (p / edge).array().floor().cast<int>();
  return {c.x(), c.y(), c.z()};
}

/// The representatives in plain words: per sub-voxel the mean of the first `most` points.
class Plain {
 public:
  Plain(double voxel, std::size_t most) : half_(0.5 * voxel), most_(most) {}
  void insert(const std::vector<WorldPoint>& points, std::uint32_t stamp) {
    for (const WorldPoint& point : points) {
      Held& held = held_[cell(point.p_W, half_)];
      if (held.count == most_) continue;
      held.sum += point.p_W;
      ++held.count;
      held.stamp = stamp;
    }
  }
  struct Held {
    Vec3 sum = Vec3::Zero();
    std::size_t count = 0;
    std::uint32_t stamp = 0;
    Vec3 mean() const { return sum / static_cast<double>(count); }
  };
  const std::map<Key, Held>& held() const { return held_; }

 private:
  double half_;
  std::size_t most_;
  std::map<Key, Held> held_;
};

/// The same in the same sub-voxels, whatever the order.
void check_contents(const Map& map, const Plain& plain, double half, double tolerance) {
  REQUIRE(map.size() == plain.held().size());
  for (const Vec3& p : contents(map)) {
    // A mean may lie on a face but for its rounding: it is that of the sub-voxel on one of the two sides.
    bool known = false;
    for (const double nudge : {0.0, -1e-6, 1e-6}) {
      const auto found = plain.held().find(cell(p + Vec3::Constant(nudge), half));
      known = known || (found != plain.held().end() && (found->second.mean() - p).norm() < tolerance);
    }
    REQUIRE(known);
  }
}

std::vector<WorldPoint> cloud(Uniform& uniform, const Vec3& centre, double half, int count) {
  std::vector<WorldPoint> points;
  for (int i = 0; i < count; ++i) points.push_back(at(uniform.in_box(centre, half)));
  return points;
}

std::size_t count_at(const Map& map, const Vec3& query, std::uint32_t max_stamp) {
  Neighbours found;
  map.correspond(std::vector<Vec3>{query}, {.k = 5, .max_distance = 0.5, .max_stamp = max_stamp}, found);
  return found.count[0];
}

}  // namespace

TEST_CASE("oct_voxel keeps the mean of what falls into each eighth of a voxel, up to a number of points") {
  BuildEnvironment environment;
  for (const std::size_t most : {1U, 3U, 50U}) {
    for (const double origin : {0.0, 1e5}) {
      CAPTURE(most, origin);
      OctVoxel map({.voxel = 0.4, .max_points = static_cast<std::int64_t>(most)}, environment.context());
      Plain plain(0.4, most);
      Uniform uniform(most);
      std::size_t inserted = 0;
      for (std::uint32_t stamp = 1; stamp <= 20; ++stamp) {
        const auto points = cloud(uniform, Vec3(origin, -origin, 0.3), 1.0, 500);
        inserted += map.insert(points, stamp).inserted;
        plain.insert(points, stamp);
      }
      CHECK(inserted == map.size());
      check_contents(map, plain, 0.2, 1e-6);
      // Of a point per 8e-4 m^3 each sub-voxel has ten and more: what is fused is not the first point.
      const auto fused = std::count_if(plain.held().begin(), plain.held().end(),
                                       [&](const auto& held) { return held.second.count == most; });
      CHECK((fused > 0) == (most < 50));
    }
  }
}

TEST_CASE("oct_voxel finds the nearest representatives of the voxels within reach and nothing else") {
  BuildEnvironment environment;
  for (const int reach : {1, 2, 3}) {
    for (const double origin : {0.0, 5e4}) {
      CAPTURE(reach, origin);
      OctVoxel map({.voxel = 0.5, .max_points = 4, .reach = reach}, environment.context());
      Uniform uniform(static_cast<std::uint64_t>(reach));
      const Vec3 centre(origin, -origin, 0);
      map.insert(cloud(uniform, centre, 2.0, 600), 1);  // about half of the sub-voxels have one
      const std::vector<Vec3> held = contents(map);
      std::vector<Vec3> queries;
      for (int i = 0; i < 400; ++i) queries.push_back(uniform.in_box(centre, 2.5));
      std::size_t cut_off = 0;
      for (const int k : {1, 5, 20}) {
        Neighbours found;
        map.correspond(queries, {.k = k, .max_distance = 5.0}, found);
        for (std::size_t i = 0; i < queries.size(); ++i) {
          const Key from = cell(queries[i], 0.5);
          std::vector<double> seen, all;
          for (const Vec3& p : held) {
            const Key to = cell(p, 0.5);
            int far = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) far = std::max(far, std::abs(to[axis] - from[axis]));
            all.push_back((p - queries[i]).norm());
            if (far <= reach) seen.push_back(all.back());
          }
          std::sort(seen.begin(), seen.end());
          std::sort(all.begin(), all.end());
          const std::size_t n = std::min<std::size_t>(seen.size(), static_cast<std::size_t>(k));
          REQUIRE(found.count[i] == n);
          for (std::size_t j = 0; j < n; ++j) {
            const auto distance = static_cast<double>(std::sqrt(found.squared[i * found.k() + j]));
            REQUIRE(std::abs(distance - seen[j]) < 2e-6);
            if (all[j] < reach * 0.5 - 1e-6) REQUIRE(std::abs(distance - all[j]) < 2e-6);  // exact within reach
          }
          if (n < static_cast<std::size_t>(k) || seen[n - 1] > all[n - 1] + 1e-9) ++cut_off;
        }
      }
      CHECK(cut_off > 0);
    }
  }
}

TEST_CASE("oct_voxel hides a representative that moved after max_stamp, and shows one that stayed") {
  BuildEnvironment environment;
  OctVoxel map({.voxel = 0.5, .max_points = 3}, environment.context());
  const Vec3 where(0.1, 0.1, 0.1);
  const std::vector<WorldPoint> one{at(where)};
  CHECK(map.insert(one, 4).inserted == 1);
  CHECK(count_at(map, where, 3) == 0);
  CHECK(count_at(map, where, 4) == 1);
  CHECK(map.insert(std::vector<WorldPoint>{at(where + Vec3(0.03, 0, 0))}, 6).inserted == 0);
  CHECK(count_at(map, where, 5) == 0);  // it holds a point of update 6
  CHECK(count_at(map, where, 6) == 1);
  map.insert(one, 7);
  map.insert(std::vector<WorldPoint>{at(where + Vec3(0.1, 0, 0))}, 9);  // the fourth: it stays as it is
  CHECK(count_at(map, where, 6) == 0);
  CHECK(count_at(map, where, 7) == 1);
  CHECK((contents(map)[0] - (where + Vec3(0.01, 0, 0))).norm() < 1e-6);
}

TEST_CASE("oct_voxel: what no query about the past may see, over random lives, is what moved later") {
  BuildEnvironment environment;
  OctVoxel map({.voxel = 0.5, .max_points = 5}, environment.context());
  Plain plain(0.5, 5);
  Uniform uniform(4);
  for (std::uint32_t stamp = 1; stamp <= 30; ++stamp) {
    const auto points = cloud(uniform, Vec3(0.1 * stamp, 0, 0), 1.5, 200);
    map.insert(points, stamp);
    plain.insert(points, stamp);
  }
  std::size_t hidden = 0;
  for (const std::uint32_t max_stamp : {5U, 15U, 25U, 30U}) {
    for (const auto& [key, held] : plain.held()) {
      Neighbours found;
      map.correspond(std::vector<Vec3>{held.mean()}, {.k = 1, .max_distance = 1e-4, .max_stamp = max_stamp}, found);
      REQUIRE(found.count[0] == (held.stamp <= max_stamp ? 1 : 0));
      hidden += held.stamp > max_stamp ? 1U : 0U;
    }
  }
  CHECK(hidden > 500);
}

TEST_CASE("oct_voxel: what is trimmed is forgotten, and its memory used again") {
  BuildEnvironment environment;
  OctVoxel map({.voxel = 0.5, .radius = 10.0}, environment.context());
  Uniform uniform(5);
  std::size_t after_first = 0;
  for (int place = 0; place < 8; ++place) {
    const Vec3 centre(40.0 * place, -7.0 * place, 0);
    map.trim(centre);
    REQUIRE(map.size() == 0);
    map.insert(cloud(uniform, centre, 4.0, 20000), 1);
    REQUIRE(map.size() > 4000);
    CHECK(count_at(map, centre, 1) > 0);
    CHECK(count_at(map, centre - Vec3(40.0, -7.0, 0), 1) == 0);
    if (place == 0) after_first = map.memory_bytes();
  }
  CHECK(map.memory_bytes() < after_first + after_first / 8);
  // A voxel across the limit stays as a whole, and none within it goes.
  map.clear();
  map.insert(cloud(uniform, Vec3::Zero(), 15.0, 50000), 1);
  const std::vector<Vec3> before = contents(map);
  map.trim(Vec3(1, 2, 3));
  const std::vector<Vec3> after = contents(map);
  const auto within = [](const Vec3& p) { return (p - Vec3(1, 2, 3)).norm() <= 10.0; };
  CHECK(std::count_if(before.begin(), before.end(), within) == std::count_if(after.begin(), after.end(), within));
  for (const Vec3& p : after) REQUIRE((p - Vec3(1, 2, 3)).norm() < 10.0 + 0.5 * std::sqrt(3.0));
}

TEST_CASE("oct_voxel: copies without end, tiny numbers and the last voxels of the range change nothing else") {
  BuildEnvironment environment;
  OctVoxel map({.voxel = 0.5, .max_points = 65535}, environment.context());
  const std::vector<WorldPoint> copies(70000, at(Vec3(0.3, -0.2, 1e-300)));
  CHECK(map.insert(copies, 1).inserted == 1);
  REQUIRE(map.size() == 1);
  CHECK((contents(map)[0] - copies[0].p_W).norm() < 1e-6);
  const double last = 0.5 * kCellLimit;
  const std::vector<Vec3> corners{{last - 0.1, last - 0.1, last - 0.1}, {0.1 - last, 0.1 - last, 0.1 - last}};
  for (const Vec3& p : corners) {
    CHECK(map.insert(std::vector<WorldPoint>{at(p)}, 1).inserted == 1);
    CHECK(count_at(map, p, 1) == 1);  // the voxels around it have keys, and none is that of another
    CHECK(map.insert(std::vector<WorldPoint>{at(p * 1.000001)}, 1).inserted == 0);
  }
  CHECK(map.size() == 3);
}
