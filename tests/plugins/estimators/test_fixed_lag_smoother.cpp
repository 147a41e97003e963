// A registration with a smoother behind it: velocity and biases come from the smoother, and what is no state of a
// vehicle starts it anew.
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

std::string smoother(const std::string& keys) { return "estimator={type: fixed_lag_smoother" + keys + "}"; }

}  // namespace

TEST_CASE("fixed_lag_smoother: velocity and the bias of the gyro come from poses and the IMU between them") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.4), .drift = Vec3(0.4, 0.2, 0)};
  Filter filter({smoother(", sigma_rotation: 0.005, sigma_position: 0.01")}, 3.0);
  filter.build_map(1);
  const Vec3 bias(0.02, -0.01, 0.015);
  double first_turn = 0, last_turn = 0;
  for (std::uint32_t k = 0; k < 40; ++k) {
    const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
    RoomWindow room(end - kTenth, kTenth, motion, k + 2);
    for (ImuSample& sample : room.imu) sample.gyro += bias;
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    const double off = log_so3(update.prior.R.transpose() * motion.at(end).R).norm();
    (k == 0 ? first_turn : last_turn) = off;
    CHECK((update.state.p - motion.at(end).p).norm() < 0.03);
  }
  const NavState& found = filter.estimator->state();
  CHECK((found.b_w - bias).norm() < 0.6 * bias.norm());  // slowly: initialisation vouches for 1e-3 rad/s
  CHECK((found.v - motion.drift).norm() < 0.1);
  CHECK(first_turn > 0.002);  // 0.027 rad/s over 0.1 s
  CHECK(last_turn < 0.9 * first_turn);
}

TEST_CASE("fixed_lag_smoother: a state that no vehicle has starts it anew") {
  const TurningRoom motion{.drift = Vec3(0.4, 0.2, 0)};
  Filter filter({smoother(", max_speed: 0.2")}, 3.0);
  filter.build_map(1);
  for (std::uint32_t k = 0; k < 10; ++k) {
    const TimeNs end = kRoomEpoch + (k + 1) * kTenth;
    const Update& update = filter.update(RoomWindow(end - kTenth, kTenth, motion, k + 2));
    REQUIRE(update.accepted);
    CHECK(update.state.v.norm() <= 0.2);
    CHECK((update.state.p - motion.at(end).p).norm() < 0.03);  // the registration goes on
    CHECK(update.P.allFinite());
  }
}

TEST_CASE("fixed_lag_smoother: begun anew, it does not vouch for the velocity of a start at rest") {
  const TurningRoom motion{.drift = Vec3(2.5, 0.8, 0)};
  Filter filter({smoother(", max_bias: 0.5, sigma_position: 0.01")}, 0.05);
  filter.build_map(1);
  for (std::uint32_t k = 0; k < 8; ++k) {
    const Update& update = filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
    REQUIRE(update.accepted);
  }
  // Held at 0.05 m/s, the motion would become a bias beyond max_bias, again and again.
  CHECK((filter.estimator->state().v - motion.drift).norm() < 0.2);
  CHECK(filter.estimator->state().b_a.norm() < 0.3);
}

TEST_CASE(
    "fixed_lag_smoother: while its front seeks the velocity of a start in motion nothing is smoothed") {  // eq. INI-3
  const TurningRoom motion{.drift = Vec3(1.0, 0.5, 0)};
  Filter filter({smoother(", front: {type: ieskf}")});
  filter.build_map(1);
  const InitialState initial = start_in_motion();
  filter.estimator->reset(initial);
  for (std::uint32_t k = 0; k < 12; ++k) {
    const Update& update = filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
    CAPTURE(k);
    REQUIRE(update.accepted);
    CHECK(update.restart_map == (k < 5));
    CHECK(update.P.allFinite());
    CHECK((update.state.b_w == initial.state.b_w) == (k < 5));
  }
  CHECK((filter.estimator->state().v - motion.drift).norm() < 0.2);
}

TEST_CASE("fixed_lag_smoother predicts with what it has found") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.4), .drift = Vec3(0.4, 0.2, 0)};
  Filter filter({smoother("")}, 3.0);
  filter.build_map(1);
  for (std::uint32_t k = 0; k < 10; ++k) filter.update(RoomWindow(kRoomEpoch + k * kTenth, kTenth, motion, k + 2));
  const RoomWindow next(kRoomEpoch + 10 * kTenth, kTenth, motion, 12);
  const NavState ahead = filter.estimator->predict(next.imu);
  CHECK(ahead.t == next.window.plan.end);
  CHECK((ahead.p - filter.update(next).prior.p).norm() < 1e-9);
}

TEST_CASE("fixed_lag_smoother: what its front finds of the gyro's scale is not found again as a bias") {  // eq. MOT-6
  const double scale_error = 0.02, rate = 1.0;
  Filter filter(
      {smoother(", sigma_rotation: 0.002, gyro_bias_walk: 1e-3, "
                "front: {type: ieskf, noise: physical, gyro_calibration: full}")});
  filter.build_map(1);
  // At rest first, which tells the bias: none.
  constexpr int rest = 10;
  filter.initial.state.t = kRoomEpoch - rest * kTenth;
  filter.estimator->reset(filter.initial);
  const TurningRoom motion{.rate = Vec3(0, 0, rate), .gyro_error = Vec3(0, 0, scale_error)};
  for (int k = -rest; k < 30; ++k) {
    const TimeNs begin = kRoomEpoch + k * kTenth;
    const auto sequence = static_cast<std::uint32_t>(k + rest + 2);
    const Update& update = k < 0 ? filter.update(RoomWindow(begin, kTenth, Pose{}, sequence, 3000))
                                 : filter.update(RoomWindow(begin, kTenth, motion, sequence));
    CAPTURE(k);
    REQUIRE(update.accepted);
    const NavState& found = filter.estimator->state();
    CAPTURE(found.S_w(2, 2), found.b_w.z());
    if (k < 10) continue;
    CHECK(std::abs(found.b_w.z()) < 0.1 * scale_error * rate);
    CHECK(found.S_w(2, 2) == Approx(scale_error).epsilon(0.1));
  }
}

TEST_CASE("fixed_lag_smoother refuses a front that begins anew with what it is told") {
  for (const std::string front : {"{type: smoother}", "{type: fixed_lag_smoother}"}) {
    CHECK_THROWS_WITH(Filter({smoother(", front: " + front)}), Catch::Contains("never smooths"));
  }
}

TEST_CASE("fixed_lag_smoother refuses a front without IMU") {
  CHECK_THROWS_AS(Filter({smoother(", front: {type: icp}")}), ConfigError);
  CHECK_THROWS_AS(Filter({smoother(", front: {type: scan_matcher, prediction: constant_velocity}")}), ConfigError);
}
