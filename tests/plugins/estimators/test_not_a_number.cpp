// A residual whose information is not a number: the update says so, rather than to go on without its rows.
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("a residual with information that is not a number makes an update that is not finite") {
  const std::string type = GENERATE("ieskf", "icp", "ct_icp", "smoother", "pointwise_eskf", "spline_iekf");
  CAPTURE(type);
  Filter filter({"estimator={type: " + type + ", residual: unknown}"});
  filter.build_map(1);
  const NavState before = filter.estimator->state();
  const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2));
  CHECK(update.status == UpdateStatus::non_finite);
  CHECK_FALSE(update.accepted);
  CHECK(update.P.allFinite());
  CHECK((update.state.p - before.p).norm() < 0.1);
  CHECK(update.state.R.allFinite());
}
