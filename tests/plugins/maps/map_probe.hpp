#pragma once
/// What a map does that its interface does not say, found by trying it.

#include "plugins/maps/map_fixture.hpp"
#include "plugins/maps/oracle_sequence.hpp"

namespace aslio::test {

/// Whether queries find lines alone or all else, as against every point. Pre: `map` is new.
inline bool tells_kinds(Map& map) {
  using namespace feature_class;
  std::vector<WorldPoint> points{at({0.1, 0.1, 0.1}), at({0.6, 0.1, 0.1}), at({0.1, 0.6, 0.1})};
  points[0].feature = line;
  points[1].feature = none;
  points[2].feature = plane;
  REQUIRE(map.insert(points, 1).inserted == 3);
  std::vector<std::size_t> found_by_class;
  for (const std::uint8_t feature : {line, none, plane}) {
    MapQuery ask;
    ask.feature = feature;
    Neighbours found;
    map.correspond(std::vector<Vec3>{points[0].p_W}, ask, found);
    found_by_class.push_back(found.count[0]);
  }
  if (found_by_class == std::vector<std::size_t>{3, 3, 3}) return false;
  REQUIRE(found_by_class == std::vector<std::size_t>{1, 2, 2});
  return true;
}

/// Whether every point of a life is taken in, and held in just its place: neither left out nor rounded. Pre: `map` is
/// new.
inline bool holds_all_as_given(Map& map, const Life& life) {
  LifeSteps steps(life, map.radius());
  std::vector<Vec3> given;
  while (given.size() < life.total) {
    const LifeStep step = steps.next();
    for (const WorldPoint& point : step.batch) given.push_back(point.p_W);
    if (map.insert(step.batch, step.stamp).inserted < step.batch.size()) return false;
    if (step.trim) map.trim(step.centre);
    if (step.clear) map.clear();
    if (!step.check) continue;
    std::sort(given.begin(), given.end(), before_by_place);
    for (const Vec3& p : contents(map)) {
      if (!std::binary_search(given.begin(), given.end(), p, before_by_place)) return false;
    }
  }
  return true;
}

/// Trims: of what visit() says the map holds, all within the radius stays, and nothing comes to it.
inline void check_trim_by_visit(Map& map, const Vec3& centre, double beyond) {
  const std::vector<Vec3> before = sorted_contents(map);
  map.trim(centre);
  const std::vector<Vec3> after = sorted_contents(map);
  for (const Vec3& p : after) REQUIRE((p - centre).norm() <= map.radius() + beyond);
  std::vector<Vec3> within;
  for (const Vec3& p : before) {
    if ((p - centre).norm() < map.radius() - 1e-4) within.push_back(p);  // a point may have been rounded
  }
  REQUIRE(std::includes(after.begin(), after.end(), within.begin(), within.end(), before_by_place));
  REQUIRE(std::includes(before.begin(), before.end(), after.begin(), after.end(), before_by_place));
}

/// A life of a map that leaves points out or rounds them: what it holds is what it says, and its neighbours are those
/// of brute force over that. One kind alone, and all stamps: visit() does not tell them. Pre: `map` is new.
inline void check_life_by_visit(Map& map, const Life& life) {
  LifeSteps steps(life, map.radius());
  Draw draw(life.seed + 1);
  std::size_t checked = 0;
  for (std::size_t offered = 0; offered < life.total;) {
    LifeStep step = steps.next();
    for (WorldPoint& point : step.batch) point.feature = feature_class::none;
    offered += step.batch.size();
    const std::size_t before = map.size();
    const InsertCount count = map.insert(step.batch, step.stamp);
    REQUIRE(count.offered == step.batch.size());
    REQUIRE(count.inserted <= count.offered);
    REQUIRE(map.size() == before + count.inserted);
    if (step.trim) check_trim_by_visit(map, step.centre, life.beyond);
    if (step.clear) {
      map.clear();
      REQUIRE(map.size() == 0);
    }
    if (!step.check) continue;
    ++checked;
    MapQuery ask;
    ask.k = draw(1, Neighbours::kMax);
    ask.max_distance = draw(1, life.most_quarters) * 0.25;
    check_against_visit(map, life_queries(draw, step), ask);
  }
  REQUIRE(checked * 20000 > life.total);
}

}  // namespace aslio::test
