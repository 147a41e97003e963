#include "insertions/on_new.hpp"

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/insertions/recording_map.hpp"

namespace aslio {

using test::RecordingMap;

TEST_CASE("on_new inserts each fresh point of the map use once, under the number of its update") {
  test::BuildEnvironment environment;
  plugins::InsertOnNew insertion({}, environment.context());
  RecordingMap map;
  std::size_t offered = 0;
  TimeNs t = 0;
  for (std::uint32_t k = 1; k <= 20; ++k) {
    std::vector<WorldPoint> map_points(10 * k % 37), match_points(50), overlap_points(70);
    for (WorldPoint& p : map_points) p.t = ++t;
    for (WorldPoint& p : match_points) p.t = -1;
    for (WorldPoint& p : overlap_points) p.t = -2;
    Update update;
    update.map_points = map_points;
    update.match_points = match_points;
    update.overlap_points = overlap_points;
    Window window;
    window.sequence = k;
    const InsertCount count = insertion.apply(window, update, map);
    CHECK(count.offered == map_points.size());
    CHECK(count.inserted == map_points.size() / 2);  // what the map says, not what it was offered
    offered += count.offered;
    for (const WorldPoint& p : map_points) {
      REQUIRE(map.stamps.count(p.t) == 1);
      CHECK(map.stamps.find(p.t)->second == k);
    }
  }
  CHECK(map.size() == offered);
  CHECK(map.size() == static_cast<std::size_t>(t));
}

}  // namespace aslio
