// A view is degenerate by what 0.1 s of it know, whatever the windows are (eq. IESKF-7).
#include <catch2/catch.hpp>
#include <cmath>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("a view does not become degenerate by being cut into shorter windows") {
  constexpr TimeNs tenth = kSecond / 10;
  for (const std::string type : {"ieskf", "smoother", "ct_icp", "icp", "pointwise_eskf", "spline_iekf"}) {
    CAPTURE(type);
    const auto update = [&](double sigma, TimeNs length, int points) {
      Filter filter({"estimator={type: " + type + ", degenerate_sigma: " + std::to_string(sigma) + "}"}, 0.01);
      filter.build_map(1);
      const Update& found = filter.update(RoomWindow(kRoomEpoch, length, Pose{}, 2, points));
      REQUIRE(found.accepted);
      return std::pair(found.status == UpdateStatus::degenerate, found.spectrum[0]);
    };
    // A threshold that the points of a window pass by half, and another number of them does not.
    const double whole = std::sqrt(1.5 / update(0.05, tenth, 2000).second);
    CHECK_FALSE(update(whole, tenth, 2000).first);
    CHECK(update(whole, tenth, 400).first);
    const double part = std::sqrt(1.5 / (5 * update(0.05, tenth / 5, 400).second));
    CHECK_FALSE(update(part, tenth / 5, 400).first);
    CHECK(update(part / 1.5, tenth / 5, 400).first);
  }
}
