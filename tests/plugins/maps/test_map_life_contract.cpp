// A random life of every registered map of points with its default parameters, or of the one under test as configured.
#include <catch2/catch.hpp>

#include "plugins/maps/map_fixture.hpp"
#include "plugins/maps/map_probe.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("every map of points: a random life of 1e5 points against brute force, bit by bit if it keeps them all") {
  EveryMap fixture;
  for (const auto& type : fixture.types(MapContent::points)) {
    bool by_visit = false;
    for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(100000, -50000, 1000)}) {
      INFO(type << " at " << centre.transpose());
      const auto map = fixture.make(type);
      // As far as the cases of test_map_contract.cpp let a map keep what is beyond its radius.
      const Life life{.total = 100000, .centre = centre, .seed = 7, .beyond = 0.2 * map->radius() + 10.0};
      if (holds_all_as_given(*fixture.make(type), life)) {
        check_random_life(*map, life, {.tells_kinds = tells_kinds(*fixture.make(type))});
      } else {
        check_life_by_visit(*map, life);
        by_visit = true;
      }
    }
    if (by_visit && one_under_test(Map::family)) {
      WARN(type << " leaves points out (by thinning, or because it is full) or rounds them, so that its neighbours "
                   "were compared with what its visit() tells, not with what was inserted: a point lost from both "
                   "would not be noticed. Add a second aslio_add_contract_test with PARAMETERS that turn thinning off "
                   "(a spacing of 0, no limit of points; edges of cells that are a power of two).");
    }
  }
}
