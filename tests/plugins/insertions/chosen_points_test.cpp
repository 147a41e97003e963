// min_distance and cell_nearest against their rule, point by point, over maps that refuse nothing themselves.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "insertions/spaced_points.hpp"
#include "plugins/insertions/every_insertion.hpp"

namespace aslio {
namespace {

using test::EveryInsertion;
using test::Uniform;

const std::vector<std::string> kPlainMaps = {"{type: voxel_hash, min_spacing: 0, max_points: 4096}",
                                             "{type: ikd_tree, leaf: 0}"};

/// Points around a moving centre, some of them once more at nearly the same place, both far from the origin and not.
std::vector<WorldPoint> batch(Uniform& uniform, const Vec3& centre) {
  std::vector<WorldPoint> points;
  for (int i = 0; i < 300; ++i) {
    points.push_back(test::at(uniform.in_box(centre, 1.0)));
    if (i % 5 == 0) points.push_back(test::at(uniform.in_box(points.back().p_W, 0.02)));
  }
  return points;
}

std::vector<Vec3> places(std::vector<Vec3> points) {
  std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  return points;
}

/// Plays batches and compares the map with what `enters(p, before, taken)` lets in.
template <class Enters>
void check_rule(const std::string& text, Enters enters) {
  EveryInsertion every;
  for (const std::string& map_text : kPlainMaps) {
    for (const double origin : {0.0, 4e4}) {
      CAPTURE(text, map_text, origin);
      const auto insertion = every.insertion(text);
      const auto map = every.map(map_text);
      CHECK(insertion->needs_nearest_points());
      Uniform uniform(3);
      std::vector<Vec3> expected;
      std::size_t refused = 0;
      for (std::uint32_t k = 1; k <= 12; ++k) {
        const auto points = batch(uniform, Vec3(origin + 0.5 * k, -0.3 * k, 0));
        std::vector<Vec3> taken;
        for (const WorldPoint& p : points) {
          if (enters(p.p_W, expected, taken)) taken.push_back(p.p_W);
        }
        Update update;
        update.map_points = points;
        Window window;
        window.sequence = k;
        const InsertCount count = insertion->apply(window, update, *map);
        REQUIRE(count.offered == points.size());
        REQUIRE(count.inserted == taken.size());
        refused += points.size() - taken.size();
        expected.insert(expected.end(), taken.begin(), taken.end());
      }
      CHECK(refused > 300);
      CHECK(expected.size() > 300);
      const auto held = places(test::contents(*map));
      expected = places(expected);
      REQUIRE(held.size() == expected.size());
      double worst = 0;
      for (std::size_t i = 0; i < held.size(); ++i) worst = std::max(worst, std::abs(held[i].x() - expected[i].x()));
      CHECK(worst < 1e-6);
    }
  }
}

}  // namespace

TEST_CASE("min_distance: what enters is no nearer to the map nor to what has entered with it") {
  check_rule("{type: min_distance, distance: 0.15}",
             [](const Vec3& p, const std::vector<Vec3>& before, const std::vector<Vec3>& taken) {
               const auto far = [&](const Vec3& q) { return (q - p).norm() >= 0.15; };
               return std::all_of(before.begin(), before.end(), far) && std::all_of(taken.begin(), taken.end(), far);
             });
}

TEST_CASE("cell_nearest: what enters has no neighbour in the map nearer to the centre of its cell") {  // eq. INS-2
  const double cell = 0.2;
  const auto squared_to_centre = [&](const Vec3& q, const Vec3& p) {
    const Vec3 centre(cell * (std::floor(p.x() / cell) + 0.5), cell * (std::floor(p.y() / cell) + 0.5),
                      cell * (std::floor(p.z() / cell) + 0.5));
    return (q - centre).squaredNorm();
  };
  const auto nearest = [&](std::size_t k) {
    return [&squared_to_centre, k](const Vec3& p, const std::vector<Vec3>& before, const std::vector<Vec3>&) {
      std::vector<Vec3> sorted = before;
      std::sort(sorted.begin(), sorted.end(),
                [&](const Vec3& a, const Vec3& b) { return (a - p).squaredNorm() < (b - p).squaredNorm(); });
      sorted.resize(std::min(k, sorted.size()));
      return std::none_of(sorted.begin(), sorted.end(),
                          [&](const Vec3& q) { return squared_to_centre(q, p) < squared_to_centre(p, p); });
    };
  };
  check_rule("{type: cell_nearest, cell: 0.2}", nearest(5));
  check_rule("{type: cell_nearest, cell: 0.2, k: 1}", nearest(1));
}

TEST_CASE("cell_nearest: a point as near to the centre as its neighbour enters") {
  EveryInsertion every;
  const auto insertion = every.insertion("{type: cell_nearest, cell: 0.5}");
  const auto map = every.map(kPlainMaps[0]);
  const std::vector<WorldPoint> points = {test::at({0.125, 0.25, 0.25})};
  Update update;
  update.map_points = points;
  for (std::uint32_t k = 1; k <= 3; ++k) {
    Window window;
    window.sequence = k;
    CHECK(insertion->apply(window, update, *map).inserted == 1);
  }
}

TEST_CASE("cell_nearest over a map of one point per cell: the cell keeps the nearest to its centre ever offered") {
  EveryInsertion every;
  const auto insertion = every.insertion("{type: cell_nearest, cell: 0.5}");
  const auto thinned = every.map("{type: ikd_tree, leaf: 0.5}"), all = every.map("{type: ikd_tree, leaf: 0.5}");
  Uniform uniform(5);
  std::size_t offered = 0, inserted = 0;
  for (std::uint32_t k = 1; k <= 20; ++k) {
    const auto points = batch(uniform, Vec3(0.3 * k, 0, 0));
    Update update;
    update.map_points = points;
    Window window;
    window.sequence = k;
    inserted += insertion->apply(window, update, *thinned).inserted;
    offered += all->insert(points, k).offered;
  }
  CHECK(inserted < offered / 10);
  CHECK(test::contents(*thinned) == test::contents(*all));  // the rule saves work and loses nothing
}

TEST_CASE("spaced points: nothing not finite or beyond all cells, whatever is near across a cell") {
  plugins::SpacedPoints spaced(0.1);
  spaced.begin(20);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Vec3& p : {Vec3(nan, 0, 0), Vec3(0, inf, 0), Vec3(0, 0, -1e30)}) spaced.offer(test::at(p));
  CHECK(spaced.taken().empty());
  spaced.offer(test::at({-0.01, -0.01, -0.01}));
  spaced.offer(test::at({0.01, 0.01, 0.01}));  // seven cells on, 3.5 cm away
  CHECK(spaced.taken().size() == 1);
  spaced.offer(test::at({0.09, 0.09, 0.09}));
  CHECK(spaced.taken().size() == 2);
  spaced.begin(20);
  CHECK(spaced.taken().empty());
  spaced.offer(test::at({0.01, 0.01, 0.01}));
  CHECK(spaced.taken().size() == 1);
}

TEST_CASE("min_distance and cell_nearest look among points of the same kind, in every map that tells kinds apart") {
  const auto classed = [](const Vec3& p, std::uint8_t feature) {
    WorldPoint point = test::at(p);
    point.feature = feature;
    return point;
  };
  using namespace feature_class;
  EveryInsertion every;
  const Vec3 centre(0.25, 0.25, 0.25), aside(0.3, 0.25, 0.25), corner(0.45, 0.45, 0.45);
  for (const std::string text : {"{type: min_distance, distance: 0.1}", "{type: cell_nearest, cell: 0.5}"}) {
    for (const std::string map_text : {"{type: ikd_tree, leaf: 0}", "{type: feature_maps}"}) {
      CAPTURE(text, map_text);
      const auto insertion = every.insertion(text);
      const auto map = every.map(map_text);
      std::uint32_t stamp = 0;
      const auto entered = [&](const std::vector<WorldPoint>& points) {
        Update update;
        update.map_points = points;
        Window window;
        window.sequence = ++stamp;
        return insertion->apply(window, update, *map).inserted;
      };
      CHECK(entered({classed(centre, line), classed(centre, none)}) == 2);  // nor do two kinds of one update meet
      const Vec3& late = text.find("min") != std::string::npos ? aside : corner;
      CHECK(entered({classed(late, line)}) == 0);
      CHECK(entered({classed(late, plane)}) == 0);
    }
    const auto insertion = every.insertion(text);
    const auto map = every.map("{type: ikd_tree, leaf: 0}");
    Update update;
    Window window;
    window.sequence = 1;
    const std::vector<WorldPoint> lines{classed(centre, line)}, planes{classed(aside, plane)};
    update.map_points = lines;
    insertion->apply(window, update, *map);
    update.map_points = planes;
    window.sequence = 2;
    CHECK(insertion->apply(window, update, *map).inserted == 1);
  }
}

}  // namespace aslio
