// The voxel hash beyond the contract: spacing, caps, reach beyond one voxel, the index of cells.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "maps/voxel_hash.hpp"
#include "plugins/build_environment.hpp"

using namespace aslio;

using plugins::VoxelHash;

namespace {

WorldPoint at(double x, double y, double z) {
  WorldPoint point;
  point.p_W = Vec3(x, y, z);
  return point;
}

double uniform(std::mt19937_64& engine, double lo, double hi) {
  return lo + (hi - lo) * static_cast<double>(engine() >> 11) * 0x1p-53;
}

std::vector<WorldPoint> cloud(std::size_t n, double half, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<WorldPoint> points(n);
  for (auto& point : points) {
    const double x = uniform(engine, -half, half), y = uniform(engine, -half, half);
    point = at(x, y, uniform(engine, -half, half));
  }
  return points;
}

}  // namespace

TEST_CASE("a voxel hash refuses exactly the points nearer than the spacing to one it holds") {
  test::BuildEnvironment environment;
  for (const double voxel : {0.2, 0.5, 1.0}) {
    VoxelHash::Params params{.voxel = voxel, .min_spacing = 0.2, .max_points = 4096, .radius = 1000.0};
    VoxelHash map(params, environment.context());
    std::vector<Vec3> kept;
    for (const WorldPoint& point : cloud(4000, 1.2, 5)) {
      double nearest = 1e9;
      for (const Vec3& p : kept) nearest = std::min(nearest, (p - point.p_W).norm());
      const bool inserted = map.insert(std::vector<WorldPoint>{point}, 1).inserted == 1;
      REQUIRE(inserted == (nearest >= 0.2));
      if (inserted) kept.push_back(point.p_W);
    }
    REQUIRE(kept.size() == map.size());
    REQUIRE(kept.size() > 200);
  }
}

TEST_CASE("a voxel hash takes max_points per voxel and no more") {
  test::BuildEnvironment environment;
  VoxelHash map({.voxel = 1.0, .min_spacing = 0.0, .max_points = 17, .radius = 10.0}, environment.context());
  std::vector<WorldPoint> points(40, at(0.5, 0.5, 0.5));
  REQUIRE(map.insert(points, 1).inserted == 17);
  for (auto& point : points) point = at(-0.5, 0.5, 0.5);
  REQUIRE(map.insert(points, 1).inserted == 17);
}

TEST_CASE("a voxel hash is exact beyond one voxel as well") {
  test::BuildEnvironment environment;
  const auto points = cloud(3000, 3.0, 9);
  for (const double voxel : {0.15, 0.4, 1.0, 5.0}) {
    VoxelHash map({.voxel = voxel, .min_spacing = 0.0, .max_points = 4096, .radius = 1000.0}, environment.context());
    map.insert(points, 1);
    std::vector<Vec3> queries;
    for (const auto& point : cloud(100, 4.0, 10)) queries.push_back(point.p_W);
    MapQuery ask;
    ask.k = 7;
    ask.max_distance = 2.2;
    Neighbours found;
    map.correspond(queries, ask, found);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      std::vector<double> distances;
      for (const auto& point : points) distances.push_back((point.p_W - queries[i]).norm());
      std::sort(distances.begin(), distances.end());
      for (std::size_t j = 0; j < 7; ++j) {
        if (distances[j] > 2.2) {
          REQUIRE(found.count[i] <= j);
          break;
        }
        REQUIRE(found.count[i] > j);
        REQUIRE(static_cast<double>(found.offset(i, j).norm()) == Approx(distances[j]).margin(1e-6));
      }
    }
  }
}

TEST_CASE("what a voxel hash visits does not depend on the order of insertion, and survives a cleared map") {
  test::BuildEnvironment environment;
  VoxelHash::Params params{.voxel = 1.0, .min_spacing = 0.0, .max_points = 4096, .radius = 1000.0};
  VoxelHash forward(params, environment.context()), backward(params, environment.context());
  auto points = cloud(5000, 6.0, 2);
  forward.insert(points, 1);
  std::reverse(points.begin(), points.end());
  backward.insert(points, 1);
  backward.clear();
  backward.insert(points, 2);
  std::vector<Vec3> a, b;
  forward.visit([&](const Vec3& p) { a.push_back(p); });
  backward.visit([&](const Vec3& p) { b.push_back(p); });
  REQUIRE(a.size() == 5000);
  REQUIRE(a == b);
}

TEST_CASE("trimming frees whole voxels beyond the radius and keeps every point within it") {
  test::BuildEnvironment environment;
  VoxelHash map({.voxel = 1.0, .min_spacing = 0.0, .max_points = 4096, .radius = 5.0}, environment.context());
  const auto points = cloud(20000, 12.0, 4);
  map.insert(points, 1);
  map.trim({1, 2, 3});
  const auto within = [&](double r) {
    return static_cast<std::size_t>(
        std::count_if(points.begin(), points.end(), [&](auto& p) { return (p.p_W - Vec3(1, 2, 3)).norm() <= r; }));
  };
  REQUIRE(map.size() >= within(5.0));
  REQUIRE(map.size() <= within(5.0 + std::sqrt(3.0)));
  const std::size_t bytes = map.memory_bytes();
  map.insert(points, 1);
  map.trim({3, 2, 3});
  map.insert(points, 1);
  REQUIRE(map.memory_bytes() < 3 * bytes);
}

TEST_CASE("a cell index agrees with std::map over random insertions and removals") {
  CellIndex index;
  std::map<std::uint64_t, std::uint32_t> oracle;
  std::mt19937_64 engine(1);
  for (std::uint32_t operation = 0; operation < 200000; ++operation) {
    const VoxelCell cell{static_cast<std::int32_t>(engine() % 24) - 12, static_cast<std::int32_t>(engine() % 24) - 12,
                         static_cast<std::int32_t>(engine() % 24) - 12};
    const std::uint64_t key = pack(cell);
    const auto known = oracle.find(key);
    REQUIRE(index.find(key) == (known == oracle.end() ? CellIndex::kNone : known->second));
    if (known == oracle.end()) {
      index.insert(key, operation);
      oracle[key] = operation;
    } else {
      index.erase(key);
      oracle.erase(known);
    }
  }
}
