// The library's maps of points without thinning against brute force, bit by bit, over random lives of 1e5 points.
#include "plugins/maps/every_map.hpp"

using namespace aslio;

TEST_CASE("maps of points: bit for bit the neighbours of brute force over 1e5 points inserted, trimmed and deleted") {
  for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(100000, -50000, 1000)}) {
    test::check_every_point_map({.total = 100000, .centre = centre, .seed = 7});
  }
}
