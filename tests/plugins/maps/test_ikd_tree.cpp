// The incremental k-d tree beyond the contract: thinning, classes, depth, deletion, memory.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "maps/ikd_tree.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/maps/grid_oracle.hpp"

using namespace aslio;
using aslio::Nearest;
using plugins::IkdTree;
using plugins::PointTree;

namespace {

WorldPoint at(double x, double y, double z, std::uint8_t feature = 0) {
  WorldPoint point;
  point.p_W = Vec3(x, y, z);
  point.feature = feature;
  return point;
}

/// The rule of thinning, written with a map of cells.
class ThinnedOracle {
 public:
  explicit ThinnedOracle(double leaf) : leaf_(leaf) {}

  /// Points by which the map grows.
  std::size_t insert(const std::vector<WorldPoint>& points, std::uint32_t stamp) {
    const std::size_t before = all_.size();
    for (const WorldPoint& point : points) {
      const Vec3& p = point.p_W;
      const auto known = cells_.find(cell(p));
      if (known != cells_.end()) {
        if (from_centre(known->second) <= from_centre(p)) continue;
        all_.erase([&](const Vec3& other) { return other == known->second; });
      }
      cells_[cell(p)] = p;
      all_.insert({point}, stamp);
    }
    return all_.size() - before;
  }
  template <class Gone>
  std::size_t erase(Gone&& gone) {
    std::erase_if(cells_, [&](const auto& entry) { return gone(entry.second); });
    return all_.erase(gone);
  }
  const test::GridOracle& all() const { return all_; }

 private:
  std::array<double, 3> cell(const Vec3& p) const {
    return {std::floor(p.x() / leaf_), std::floor(p.y() / leaf_), std::floor(p.z() / leaf_)};
  }
  double from_centre(const Vec3& p) const {
    const auto c = cell(p);
    return (p - leaf_ * (Vec3(c[0], c[1], c[2]) + Vec3::Constant(0.5))).squaredNorm();
  }

  double leaf_;
  test::GridOracle all_;
  std::map<std::array<double, 3>, Vec3> cells_;
};

std::size_t nodes_in(std::size_t bytes) { return bytes / (64 + 16); }

}  // namespace

TEST_CASE("an ikd tree keeps of each cell the point nearest to its centre, over insertions and deletions") {
  test::BuildEnvironment environment;
  for (const double leaf : {0.25, 1.0}) {
    IkdTree map({.leaf = leaf, .radius = 15.0}, environment.context());
    ThinnedOracle oracle(leaf);
    test::Draw draw(3);
    Vec3 centre(-4096, 1024, 0);
    std::size_t refused = 0;
    for (std::uint32_t stamp = 1; stamp <= 120; ++stamp) {
      const auto batch = test::draw_batch(draw, centre, 600);
      const InsertCount count = map.insert(batch, stamp);
      REQUIRE(count.inserted == oracle.insert(batch, stamp));
      refused += count.offered - count.inserted;
      centre.x() += 2;
      map.trim(centre);
      oracle.erase([&](const Vec3& p) { return (p - centre).norm() > 15.0; });
      const Vec3 low = draw.near(centre, 6), high = low + Vec3(2, 1, 3);
      const auto inside = [&](const Vec3& p) { return (p.array() >= low.array() && p.array() <= high.array()).all(); };
      REQUIRE(map.erase_box(low, high) == oracle.erase(inside));
      if (stamp % 6 != 0) continue;
      oracle.all().check_contents(map);
      std::vector<Vec3> queries;
      for (int i = 0; i < 20; ++i) queries.push_back(draw.near(centre, 6));
      oracle.all().check_neighbours(map, queries, {.k = draw(1, 20), .max_stamp = stamp - 3});
    }
    REQUIRE(refused > 1000);
    REQUIRE(map.size() > 500);
  }
}

TEST_CASE("an ikd tree thins and finds lines apart from all else") {
  using namespace feature_class;
  test::BuildEnvironment environment;
  for (const std::uint8_t other : {none, plane}) {
    IkdTree map({.leaf = 0.5}, environment.context());
    REQUIRE(map.insert(std::vector<WorldPoint>{at(0.1, 0.1, 0.1, other), at(0.2, 0.1, 0.1, line)}, 1).inserted == 2);
    Neighbours found;
    for (const std::uint8_t asked : {none, line, plane}) {
      CAPTURE(int(other), int(asked));
      map.correspond(std::vector<Vec3>{{0.1, 0.1, 0.1}}, {.feature = asked}, found);
      REQUIRE(found.count[0] == 1);
      REQUIRE(found.offset(0, 0).x() == Approx(asked == line ? 0.1 : 0.0).margin(1e-6));
    }
    REQUIRE(map.insert(std::vector<WorldPoint>{at(0.25, 0.25, 0.25, none)}, 2).inserted == 0);  // in place of `other`
    REQUIRE(map.size() == 2);
  }
}

TEST_CASE("a point tree stays shallow for sorted points, copies of one point and a spiral") {
  for (const double balance : {0.55, 0.6, 0.8}) {
    for (const int kind : {0, 1, 2}) {
      PointTree tree(balance, 0.5);
      constexpr std::uint32_t n = 60000;
      for (std::uint32_t i = 0; i < n; ++i) {
        const double t = kind == 1 ? 0.0 : 1e-3 * i;
        tree.insert({kind == 2 ? t * Vec3(std::cos(t), std::sin(t), 0.1) : Vec3(t, t, -t), 1, i, 0});
        if (i % 1000 == 999) REQUIRE(tree.depth() < PointTree::kMaxDepth);
      }
      tree.settle();
      REQUIRE(tree.size() == n);
      REQUIRE(tree.depth() <= std::log(n) / std::log(1.0 / balance) + 16);
    }
  }
}

TEST_CASE("a point tree gives the nodes of deleted points back") {
  test::BuildEnvironment environment;
  IkdTree map({.leaf = 0.0, .radius = 1000.0}, environment.context());
  test::Draw draw(8);
  std::size_t most = 0;
  for (std::uint32_t round = 0; round < 30; ++round) {
    std::vector<WorldPoint> batch(20000);
    for (auto& point : batch) point.p_W = draw.near(Vec3::Zero(), 4);
    map.insert(batch, round);
    most = std::max(most, nodes_in(map.memory_bytes()));
    REQUIRE(map.erase_box(Vec3::Constant(-4), Vec3(4, 4, 3.5)) > 15000);
    REQUIRE(map.erase_box(Vec3::Constant(-4), Vec3(4, 4, 4)) > 0);
    REQUIRE(map.size() == 0);
    Neighbours found;
    map.correspond(std::vector<Vec3>{Vec3::Zero()}, {}, found);
    REQUIRE(found.count[0] == 0);
  }
  REQUIRE(most < 4 * 20000);
}

TEST_CASE("a box delete takes its boundary, and an empty box nothing") {
  test::BuildEnvironment environment;
  IkdTree map({.leaf = 0.0}, environment.context());
  std::vector<WorldPoint> points;
  for (int x = 0; x < 10; ++x) {
    for (int y = 0; y < 10; ++y) points.push_back(at(x, y, 0));
  }
  map.insert(points, 1);
  REQUIRE(map.erase_box(Vec3(2, 2, 0), Vec3(1, 9, 0)) == 0);
  REQUIRE(map.erase_box(Vec3(2, 3, -1), Vec3(4, 5, 0)) == 9);
  REQUIRE(map.erase_box(Vec3(2, 3, -1), Vec3(4, 5, 0)) == 0);
  REQUIRE(map.size() == 91);
  map.insert(std::vector<WorldPoint>{at(3, 4, 0)}, 2);
  Neighbours found;
  map.correspond(std::vector<Vec3>{{3, 4, 0}}, {.k = 3}, found);
  REQUIRE(found.count[0] == 1);
}
