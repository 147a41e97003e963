#include "insertions/whole_window.hpp"

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/insertions/random_windows.hpp"
#include "plugins/insertions/recording_map.hpp"

namespace aslio {

using test::RandomWindows;
using test::RecordingMap;

TEST_CASE("whole_window: every update inserts what is inside its window, the old points moved by the correction") {
  test::BuildEnvironment environment;  // eq. INS-1
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    plugins::InsertWholeWindow insertion({}, environment.context());
    RandomWindows windows(seed);
    std::vector<WorldPoint> inside;  // as their own updates placed them
    std::size_t old_points = 0;
    for (int k = 0; k < 200; ++k) {
      windows.next();
      const Window& window = windows.window;
      Update& update = windows.update;
      update.prior.R = exp_so3(Vec3(0.1, -0.2, 0.3));
      update.state.R = update.accepted ? exp_so3(Vec3(0.2, -0.1, 0.3)) : update.prior.R;
      RecordingMap map;
      CHECK(insertion.begin(window, map).offered == 0);
      if (!update.insert) {  // what was placed before may have drifted from what comes
        inside.clear();
        continue;
      }
      std::erase_if(inside, [&](const WorldPoint& p) { return p.t <= window.plan.history_begin; });
      const InsertCount count = insertion.apply(window, update, map);
      const auto fresh = update.points(PointUse::map);
      REQUIRE(count.offered == inside.size() + fresh.size());
      REQUIRE(count.inserted == count.offered / 2);  // what the map says
      double worst = 0;
      for (std::size_t i = 0; i < inside.size(); ++i) {
        const Vec3 p_I = update.prior.pose().inverse() * inside[i].p_W;
        worst = std::max(worst, (map.given[i].p_W - update.state.pose() * p_I).norm());
        REQUIRE(map.given[i].t == inside[i].t);
      }
      CHECK(worst < 1e-12);
      for (std::size_t i = 0; i < fresh.size(); ++i) REQUIRE(map.given[inside.size() + i].p_W == fresh[i].p_W);
      for (const auto& [t, stamp] : map.stamps) REQUIRE(stamp == window.sequence);
      old_points += inside.size();
      if (!update.accepted && update.status != UpdateStatus::initialising) {
        inside.clear();
      } else {
        inside.insert(inside.end(), fresh.begin(), fresh.end());
      }
    }
    CHECK(old_points > 500);
  }
}

TEST_CASE("whole_window: old points lie where the estimator has moved them") {
  struct Moved final : PointRevision {
    Vec3 place(const WorldPoint& point) const override {
      return point.p_W + Vec3(0, 0, 1e-9) * static_cast<double>(point.t);
    }
  } const moved;
  test::BuildEnvironment environment;  // eq. INS-1 with SMO-4
  plugins::InsertWholeWindow insertion({}, environment.context());
  RandomWindows windows(7);
  std::vector<WorldPoint> inside;  // as their own updates placed them
  std::size_t old_points = 0;
  for (int k = 0; k < 50; ++k) {
    windows.next();
    if (!windows.update.insert || !windows.update.accepted) {  // passed over, as a refused step
      inside.clear();
      continue;
    }
    std::erase_if(inside, [&](const WorldPoint& p) { return p.t <= windows.window.plan.history_begin; });
    windows.update.revision = &moved;
    RecordingMap map;
    insertion.apply(windows.window, windows.update, map);
    const auto fresh = windows.update.points(PointUse::map);
    REQUIRE(map.given.size() == inside.size() + fresh.size());
    for (std::size_t i = 0; i < inside.size(); ++i) REQUIRE(map.given[i].p_W == moved.place(inside[i]));
    for (std::size_t i = 0; i < fresh.size(); ++i) REQUIRE(map.given[inside.size() + i].p_W == fresh[i].p_W);
    old_points += inside.size();
    inside.insert(inside.end(), fresh.begin(), fresh.end());
  }
  CHECK(old_points > 100);
}

TEST_CASE("whole_window: a map that begins anew takes the points of that update alone") {
  test::BuildEnvironment environment;
  plugins::InsertWholeWindow insertion({}, environment.context());
  RecordingMap map;
  const std::vector<WorldPoint> old = {{.t = 10}, {.t = 20}}, first = {{.t = 30}}, later = {{.t = 50}};
  Update update;
  update.map_points = old;
  insertion.apply(test::window_of(1, 0, 0, 25), update, map);
  map.clear();
  update.restart_map = true;
  update.map_points = first;
  insertion.apply(test::window_of(2, 0, 25, 45), update, map);
  CHECK(map.stamps == std::multimap<TimeNs, std::uint32_t>{{30, 2}});
  update.restart_map = false;
  update.map_points = later;
  insertion.apply(test::window_of(3, 0, 45, 55), update, map);
  CHECK(map.stamps == std::multimap<TimeNs, std::uint32_t>{{30, 2}, {30, 3}, {50, 3}});
}

}  // namespace aslio
