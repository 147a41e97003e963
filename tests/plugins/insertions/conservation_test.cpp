// on_new and on_exit: each point of an update that was not refused enters exactly once.
#include <catch2/catch.hpp>

#include "insertions/on_exit.hpp"
#include "insertions/on_new.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/insertions/random_windows.hpp"
#include "plugins/insertions/recording_map.hpp"

namespace aslio {
namespace {

using test::RandomWindows;
using test::RecordingMap;

bool same_point(const WorldPoint& a, const WorldPoint& b) { return a.p_W == b.p_W && a.t == b.t; }

/// Plays random windows to the end of the stream and returns all map points of updates that were not refused. At every
/// update `check(windows, map, points)`.
template <class Check>
std::vector<WorldPoint> play(Insertion& insertion, std::uint64_t seed, RecordingMap& map, Check check) {
  RandomWindows windows(seed);
  std::vector<WorldPoint> points;
  std::multimap<TimeNs, std::uint32_t> measured;
  std::size_t offered = 0;
  for (int k = 0; k < 300; ++k) {
    windows.next();
    offered += insertion.begin(windows.window, map).offered;
    check(windows, map, points);
    if (!windows.update.insert) continue;
    offered += insertion.apply(windows.window, windows.update, map).offered;
    for (const WorldPoint& p : windows.update.points(PointUse::map)) {
      points.push_back(p);
      measured.emplace(p.t, windows.window.sequence);
    }
  }
  REQUIRE(offered == map.given.size());
  insertion.finish(map);
  insertion.finish(map);  // nothing is left
  REQUIRE(map.stamps == measured);
  return points;
}

void check_same(const std::vector<WorldPoint>& given, const std::vector<WorldPoint>& points) {
  REQUIRE(points.size() > 1000);
  REQUIRE(given.size() == points.size());
  CHECK(std::equal(given.begin(), given.end(), points.begin(), same_point));
}

}  // namespace

TEST_CASE("on_new: each point of an update that was not refused enters once, at its update") {
  test::BuildEnvironment environment;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    plugins::InsertOnNew insertion({}, environment.context());
    RecordingMap map;
    const auto points =
        play(insertion, seed, map, [](const RandomWindows&, const RecordingMap& m, const std::vector<WorldPoint>& all) {
          REQUIRE(m.given.size() == all.size());
        });
    check_same(map.given, points);
  }
}

TEST_CASE("on_exit: each point of an update that was not refused enters once, the last ones at the end of the stream") {
  test::BuildEnvironment environment;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    plugins::InsertOnExit insertion({}, environment.context());
    RecordingMap map;
    TimeNs latest = 0;  // begin of the window that reached farthest
    const auto points =
        play(insertion, seed, map,
             [&](const RandomWindows& windows, const RecordingMap& m, const std::vector<WorldPoint>& all) {
               latest = std::max(latest, windows.window.plan.history_begin);
               const auto left = [&](const WorldPoint& p) { return p.t <= latest; };
               REQUIRE(m.given.size() == static_cast<std::size_t>(std::count_if(all.begin(), all.end(), left)));
               REQUIRE(std::all_of(m.given.begin(), m.given.end(), left));
             });
    check_same(map.given, points);
  }
}

TEST_CASE("on_exit: a point enters where the estimator holds it by the time it leaves") {
  struct Drift final : PointRevision {
    Vec3 place(const WorldPoint& point) const override { return point.p_W + by; }
    Vec3 by = Vec3::Zero();
  };
  test::BuildEnvironment environment;
  plugins::InsertOnExit insertion({}, environment.context());
  RecordingMap map;
  Drift drift;
  const std::vector<WorldPoint> points = {{.p_W = Vec3(1, 2, 3), .t = 10}, {.p_W = Vec3(4, 5, 6), .t = 20}};
  Update update;
  update.map_points = points;
  update.revision = &drift;
  insertion.apply(test::window_of(1, 0, 0, 25), update, map);
  drift.by = Vec3(0, 0, 0.5);
  insertion.begin(test::window_of(2, 15, 25, 45), map);
  drift.by = Vec3(0.25, 0, 0);
  insertion.finish(map);
  REQUIRE(map.given.size() == 2);
  CHECK(map.given[0].p_W == Vec3(1, 2, 3.5));
  CHECK(map.given[1].p_W == Vec3(4.25, 5, 6));
}

TEST_CASE("on_exit: a map that begins anew takes the points of that update and none that waited") {
  test::BuildEnvironment environment;
  plugins::InsertOnExit insertion({}, environment.context());
  RecordingMap map;
  const std::vector<WorldPoint> old = {{.t = 10}, {.t = 20}}, first = {{.t = 30}, {.t = 40}}, later = {{.t = 50}};
  Window window = test::window_of(1, 0, 0, 25);
  Update update;
  update.map_points = old;
  insertion.apply(window, update, map);
  CHECK(map.given.empty());

  window = test::window_of(2, 0, 25, 45);
  insertion.begin(window, map);
  map.clear();
  update.restart_map = true;
  update.map_points = first;
  CHECK(insertion.apply(window, update, map).offered == 2);
  CHECK(map.stamps == std::multimap<TimeNs, std::uint32_t>{{30, 2}, {40, 2}});

  window = test::window_of(3, 35, 45, 55);
  CHECK(insertion.begin(window, map).offered == 0);
  update.restart_map = false;
  update.map_points = later;
  insertion.apply(window, update, map);
  insertion.finish(map);
  CHECK(map.stamps == std::multimap<TimeNs, std::uint32_t>{{30, 2}, {40, 2}, {50, 3}});
}

}  // namespace aslio
