// Every map of points against brute force, bit by bit, over random lives of 1e5 points.
#include "plugins/maps/every_map.hpp"

using namespace aslio;

TEST_CASE(
    "every map of points: bit for bit the neighbours of brute force over 1e5 points inserted, trimmed and deleted") {
  for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(100000, -50000, 1000)}) {
    test::for_every_point_map([&](Map& map, const test::EraseBox& erase_box, bool tells_kinds) {
      test::check_random_life(map, 100000, centre, 7, erase_box, tells_kinds);
    });
  }
}
