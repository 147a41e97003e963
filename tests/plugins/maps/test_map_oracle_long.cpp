// The library's maps of points without thinning against brute force, bit by bit, over random lives of 1e6 points.
#include "plugins/maps/every_map.hpp"

using namespace aslio;

TEST_CASE("maps of points: bit for bit the neighbours of brute force over 1e6 points inserted, trimmed and deleted") {
  test::check_every_point_map({.total = 1000000, .seed = 6});
}
