/// Interiors from unions of rooms, against brute force on a grid of half metres.

#include <array>
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/random.hpp"
#include "simulator/worlds/world_checks.hpp"
#include "worlds/floor_plan.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::indoor;

namespace {

constexpr int kCells = 24;
constexpr double kCell = 0.5;

/// Free between two heights, in every cell of the brute-force grid.
struct Column {
  double floor = 0, ceiling = 0;
  bool solid() const { return ceiling <= floor; }
};

/// Random rooms with corners on the grid, and what they leave free.
struct Case {
  FloorPlan plan;
  std::vector<Column> columns = std::vector<Column>(kCells * kCells);

  explicit Case(std::uint64_t seed) {
    RandomStream random(seed, 1);
    const std::array floors{0.0, 0.5, 1.0}, ceilings{2.0, 2.5, 3.0};
    for (int k = 0; k < 12; ++k) {
      const int i = static_cast<int>(random.uniform(1, kCells - 8)),
                j = static_cast<int>(random.uniform(1, kCells - 8));
      const int w = static_cast<int>(random.uniform(1, 7)), h = static_cast<int>(random.uniform(1, 7));
      const double floor = floors.at(static_cast<std::size_t>(random.uniform(0, 3)));
      const double ceiling = ceilings.at(static_cast<std::size_t>(random.uniform(0, 3)));
      plan.add({{kCell * Vec2(i, j), kCell * Vec2(i + w, j + h)}, floor, ceiling});
      for (int v = j; v < j + h; ++v) {
        for (int u = i; u < i + w; ++u) {
          Column& c = columns.at(static_cast<std::size_t>(v * kCells + u));
          c = c.solid() ? Column{floor, ceiling} : Column{std::min(c.floor, floor), std::max(c.ceiling, ceiling)};
        }
      }
    }
  }

  Column at(int i, int j) const {
    if (i < 0 || j < 0 || i >= kCells || j >= kCells) return {};
    return columns.at(static_cast<std::size_t>(j * kCells + i));
  }
  bool free(const Vec3& p) const {
    const Column c = at(static_cast<int>(std::floor(p.x() / kCell)), static_cast<int>(std::floor(p.y() / kCell)));
    return p.z() > c.floor && p.z() < c.ceiling;
  }
  bool all_free(int i0, int j0, int i1, int j1, double low, double high) const {
    for (int j = j0; j < j1; ++j)
      for (int i = i0; i < i1; ++i)
        if (at(i, j).solid() || at(i, j).floor > low || at(i, j).ceiling < high) return false;
    return true;
  }
};

/// Height of `a` that stands free before `b`.
double exposed(const Column& a, const Column& b) {
  if (a.solid()) return 0;
  const double height = a.ceiling - a.floor;
  return b.solid() ? height : height - std::max(0.0, std::min(a.ceiling, b.ceiling) - std::max(a.floor, b.floor));
}

}  // namespace

TEST_CASE("what a plan leaves free is what its rooms cover", "[worlds]") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Case test(seed);
    const PlanGrid grid(test.plan);
    RandomStream random(seed, 2);
    int free = 0;
    for (int k = 0; k < 500; ++k) {
      const int i = static_cast<int>(random.uniform(0, kCells - 5)),
                j = static_cast<int>(random.uniform(0, kCells - 5));
      const int w = static_cast<int>(random.uniform(1, 5)), h = static_cast<int>(random.uniform(1, 5));
      const double low = 0.5 * std::floor(random.uniform(0, 3)), high = 2 + 0.5 * std::floor(random.uniform(0, 3));
      const Rect area{kCell * Vec2(i, j), kCell * Vec2(i + w, j + h)};
      const bool expected = test.all_free(i, j, i + w, j + h, low, high);
      CAPTURE(seed, i, j, w, h, low, high);
      REQUIRE(grid.free(area, low, high) == expected);
      free += expected ? 1 : 0;
    }
    CHECK(free > 5);
  }
}

TEST_CASE("the walls of a plan have the area of all its exposed sides", "[worlds]") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Case test(seed);
    double expected = 0, found = 0;
    for (int j = -1; j < kCells; ++j) {
      for (int i = -1; i < kCells; ++i) {
        const Column here = test.at(i, j), right = test.at(i + 1, j), above = test.at(i, j + 1);
        expected += kCell * (exposed(here, right) + exposed(right, here) + exposed(here, above) + exposed(above, here));
      }
    }
    for (const WallFace& face : PlanGrid(test.plan).walls()) {
      found += face.length() * (face.high - face.low);
      const Vec2 before = 0.5 * (face.a + face.b) + 0.01 * face.normal, behind = before - 0.02 * face.normal;
      const double z = 0.5 * (face.low + face.high);
      CAPTURE(seed, face.a.transpose(), face.b.transpose());
      CHECK(test.free({before.x(), before.y(), z}));
      CHECK_FALSE(test.free({behind.x(), behind.y(), z}));
    }
    CHECK(found == Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("rays inside a plan end where it becomes solid", "[worlds]") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Case test(seed);
    MeshBuilder builder;
    PlanGrid(test.plan).build(builder, {});
    const Caster caster(builder.take());
    RandomStream random(seed, 3);
    int rays = 0;
    while (rays < 300) {
      const Vec3 from(random.uniform(0, kCells * kCell), random.uniform(0, kCells * kCell), random.uniform(0, 3));
      const Vec3 towards = Vec3(random.normal(), random.normal(), random.normal()).normalized();
      // Surfaces nearer than 0.1 mm are not seen.
      bool clear = true;
      for (const Vec3& d : simulator::testing::directions_all_round(50)) clear = clear && test.free(from + 1e-3 * d);
      if (!clear) continue;
      ++rays;
      const double range = caster.cast(from, towards, 100).range;
      CAPTURE(seed, from.transpose(), towards.transpose(), range);
      REQUIRE(std::isfinite(range));
      CHECK_FALSE(test.free(from + (range + 1e-3) * towards));
      bool free = true;
      for (double t = 0; t < range - 1e-3; t += 0.01) free = free && test.free(from + t * towards);
      CHECK(free);
    }
  }
}

TEST_CASE("streets of a route: edges on a line are one", "[worlds]") {
  const Route route({{0, 0}, {5, 0}, {9, 0}, {9, 4}, {3, 4}, {3, 0.0}});
  const std::vector<Run> runs = runs_of(route, "office");
  REQUIRE(runs.size() == 4);
  CHECK((runs[0].axis == 0 && runs[0].at == 0 && runs[0].lo == 0 && runs[0].hi == 9));
  CHECK((runs[1].axis == 0 && runs[1].at == 4 && runs[1].lo == 3 && runs[1].hi == 9));
  CHECK((runs[2].axis == 1 && runs[2].at == 3 && runs[3].at == 9));
}

TEST_CASE("nothing is placed twice, in a wall or in the way", "[worlds]") {
  FloorPlan plan;
  plan.add({{{0, 0}, {4, 3}}, 0, 2.5});
  const PlanGrid grid(plan);
  Site site(grid, {Rect{{1, 1}, {2, 2}}});
  CHECK_FALSE(site.claim(Rect{{1.5, 1.5}, {2.5, 2.5}}));   // in the way
  CHECK_FALSE(site.claim(Rect{{3.5, 0.5}, {4.5, 1}}));     // in the wall
  CHECK_FALSE(site.claim(Rect{{3, 0.5}, {3.5, 1}}, 2.6));  // through the ceiling
  CHECK(site.claim(Rect{{3, 0.5}, {3.5, 1}}));
  CHECK_FALSE(site.claim(Rect{{3.2, 0.7}, {3.4, 0.8}}));  // taken
  CHECK(site.claim(at_wall(Vec2(3, 3), Vec2(0, -1)), {0, 0}, {1, 0.4}));
  CHECK_FALSE(site.claim(Rect{{2.5, 2.7}, {2.6, 2.8}}));  // where the last one stands: left of its frame
}

TEST_CASE("an open door joins two rooms, a closed one is a recess", "[worlds]") {
  FloorPlan plan;
  plan.add({{{0, 0}, {3, 3}}, 0, 2.5});
  plan.add({{{0, 3 + kWall}, {3, 6}}, 0, 2.5});
  Door door{.at = {1.5, 3}, .normal = {0, -1}, .width = 0.9};
  add_door(plan, door);
  CHECK(PlanGrid(plan).free(Rect{{1.05, 2}, {1.95, 4}}, 0, kDoorHead));
  CHECK_FALSE(PlanGrid(plan).free(Rect{{1.0, 2}, {1.95, 4}}, 0, kDoorHead));
  CHECK_FALSE(PlanGrid(plan).free(Rect{{1.05, 2}, {1.95, 4}}, 0, kDoorHead + 0.1));
  door.open = false;
  CHECK(door.area().size().y() == Approx(0.1));
}
