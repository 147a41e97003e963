// A window over a gap of the IMU: what was not read is not known (eq. MOT-9), in the estimators that predict by it.
#include <catch2/catch.hpp>
#include <cmath>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// The covariance over a window of 0.1 s in which nothing is seen, and which reaches into a gap of the IMU [ns].
StateMatrix predicted(const std::string& estimator, TimeNs gap) {
  Filter filter({"estimator=" + estimator}, 0.01, true);
  filter.build_map(1);
  filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2, 3000));
  RoomWindow blind(kRoomEpoch + kTenth, kTenth, Pose{}, 3, 3000);
  blind.window.fresh = {};
  blind.window.imu_gap = gap;
  const Update& update = filter.update(blind);
  REQUIRE_FALSE(update.accepted);
  return update.P;
}

}  // namespace

TEST_CASE("a gap of the IMU: attitude and velocity are known worse by what was not read") {
  const std::string estimator =
      GENERATE(as<std::string>{}, "{type: ieskf, noise: physical}", "{type: ieskf, noise: fastlio}",
               "{type: ct_icp, prediction: imu, noise: physical}", "{type: ieskf, noise: rate_scaled}",
               "{type: smoother, noise: physical}", "{type: fixed_lag_smoother}");
  CAPTURE(estimator);
  const auto [gap, of] = GENERATE(table<double, double>({{0.05, 0.05}, {0.4, 0.4}, {1.0, 0.4}}));
  CAPTURE(gap);
  const StateMatrix grown = predicted(estimator, to_ns(gap)) - predicted(estimator, 0);
  if (estimator.find("fastlio") != std::string::npos) {
    CHECK(grown.isZero());  // as published
    return;
  }
  const double rate = 5 * of, acceleration = 12.5 * of;
  for (int axis = 0; axis < 3; ++axis) {
    const int theta = block::theta + axis, v = block::v + axis;
    CHECK(std::sqrt(grown(theta, theta)) == Approx(rate * std::sqrt(of * 0.1)).epsilon(0.02));
    // Across gravity, the attitude adds to it: g t / 2 by 2.5 %.
    CHECK(std::sqrt(grown(v, v)) > 0.98 * acceleration * std::sqrt(of * 0.1));
    CHECK(std::sqrt(grown(v, v)) < 1.05 * acceleration * std::sqrt(of * 0.1));
  }
}
