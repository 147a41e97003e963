// Every map of points against brute force, bit by bit, over random lives of 1e6 points.
#include "plugins/maps/every_map.hpp"

using namespace aslio;

TEST_CASE(
    "every map of points: bit for bit the neighbours of brute force over 1e6 points inserted, trimmed and deleted") {
  test::for_every_point_map([&](Map& map, const test::EraseBox& erase_box, bool tells_kinds) {
    test::check_random_life(map, 1000000, Vec3(0, 0, 0), 6, erase_box, tells_kinds);
  });
}
