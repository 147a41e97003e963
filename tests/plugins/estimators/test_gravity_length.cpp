// The length of gravity is kept (`gravity: s2`): errors along it are none, wherever it has turned to (eq. IESKF-14).
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr double kTilt = 8.0;  // of gravity at the start [deg]

/// At rest in a room for 10 s, with an accelerometer that reads 1 % too much. The vertical is known to some degrees at
/// the start, and off by so much.
void rest(Filter& filter) {
  filter.build_map(1);
  filter.initial.state.g = kStandardGravity * Vec3(std::sin(kTilt * kRadPerDeg), 0, -std::cos(kTilt * kRadPerDeg));
  filter.initial.sigma_tilt = kTilt * kRadPerDeg;
  filter.initial.sigma_acc_bias = 0.05;
  filter.estimator->reset(filter.initial);
  for (std::uint32_t k = 0; k < 100; ++k) {
    RoomWindow room(kRoomEpoch + k * kTenth, kTenth, Pose{}, k + 2, 3000);
    for (ImuSample& sample : room.imu) sample.acc = Vec3(0, 0, 1.01 * kStandardGravity);
    filter.update(room);
  }
}

}  // namespace

TEST_CASE("gravity: s2: an accelerometer that reads too much does not turn gravity away, nor drive the bias") {
  const std::string estimator =
      GENERATE(as<std::string>{}, "{type: ieskf, noise: physical}", "{type: ieskf, noise: fastlio}",
               "{type: smoother, noise: physical}", "{type: pointwise_eskf}", "{type: spline_iekf}");
  CAPTURE(estimator);
  Filter filter({"estimator=" + estimator});
  rest(filter);
  const NavState& state = filter.estimator->state();
  CHECK(state.g.norm() == Approx(kStandardGravity).epsilon(1e-9));
  CHECK(std::atan2(state.g.head<2>().norm(), -state.g.z()) / kRadPerDeg < 1.0);
  CHECK(state.b_a.head<2>().norm() < 0.15);
}

TEST_CASE("gravity: s2: its covariance lies across it after it has turned") {
  const std::string estimator =
      GENERATE(as<std::string>{}, "{type: ieskf, noise: physical}", "{type: ieskf, extrinsic: full, noise: physical}",
               "{type: smoother, noise: physical}", "{type: pointwise_eskf}", "{type: spline_iekf}",
               "{type: ct_icp, prediction: imu}");
  CAPTURE(estimator);
  Filter filter({"estimator=" + estimator});
  rest(filter);
  RoomWindow room(kRoomEpoch + 100 * kTenth, kTenth, Pose{}, 102, 3000);
  const Update& update = filter.update(room);
  REQUIRE(update.accepted);
  const Mat3 P = update.P.block<3, 3>(block::g, block::g);
  const Vec3 up = filter.estimator->state().g.normalized();
  CHECK(up.dot(P * up) < 1e-9 * P.trace());
  CHECK((P * up).norm() < 1e-6 * P.trace());
  CHECK(P.trace() > 0);
}
