// Keyframes: what is near to the last one does not enter, what has moved or turned enough does.
#include "insertions/keyframe.hpp"

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/insertions/random_windows.hpp"
#include "plugins/insertions/recording_map.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("keyframe: an update enters a metre or 0.2 rad after the last that did") {
  BuildEnvironment environment;
  plugins::InsertKeyframe insertion({}, environment.context());
  RecordingMap map;
  const std::vector<WorldPoint> points(7);
  Update update;
  update.map_points = points;
  std::uint32_t sequence = 0;
  const auto enters = [&](double x, double yaw) {
    update.state.p = Vec3(x, 0, 0);
    update.state.R = exp_so3(Vec3(0, 0, yaw));
    const TimeNs t = ++sequence;
    const std::size_t before = map.given.size();
    const InsertCount count = insertion.apply(window_of(sequence, t, t, t + 1), update, map);
    CHECK(count.offered == 7);
    return map.given.size() > before;
  };
  CHECK(enters(0, 0));
  CHECK_FALSE(enters(0.9, 0.1));
  CHECK_FALSE(enters(-0.9, -0.19));
  CHECK(enters(1.01, 0));
  CHECK_FALSE(enters(1.9, 0.15));  // from the last keyframe, not from the last update
  CHECK(enters(1.02, 0.21));
  CHECK_FALSE(enters(1.02, 0.1));
  update.restart_map = true;
  CHECK(enters(1.02, 0.1));
  update.restart_map = false;
  CHECK_FALSE(enters(1.02, 0.21));
}

TEST_CASE("keyframe: while the map is empty every update is one") {
  BuildEnvironment environment;
  plugins::InsertKeyframe insertion({}, environment.context());
  RecordingMap map;
  Update update;
  CHECK(insertion.apply(window_of(1, 1, 1, 2), update, map).offered == 0);  // a covered lens
  const std::vector<WorldPoint> points(7);
  update.map_points = points;
  CHECK(insertion.apply(window_of(2, 2, 2, 3), update, map).inserted > 0);
}
