// What is estimated besides the pose: gravity three ways, and with which prior; how long the parts of an update take.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// The state after 3 s at rest in a room that is known, begun with the gravity `g`.
struct AtRest {
  AtRest(const std::string& variant, const Vec3& g, bool imu_is_known)
      : filter({"estimator.gravity=" + variant, "estimator.noise=physical"}, 0.01, imu_is_known, g) {
    filter.build_map(1);
    for (int k = 0; k < 30; ++k) {
      const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, Pose{}, static_cast<std::uint32_t>(k + 2));
      const Update& update = filter.update(room);
      REQUIRE(update.accepted);
      state = update.state;
      P = update.P;
    }
  }
  Filter filter;
  NavState state;
  StateMatrix P;
};

Mat3 gravity_block(const StateMatrix& P) { return P.block<3, 3>(block::g, block::g); }

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

const Vec3 kDown(0, 0, -kStandardGravity);

}  // namespace

TEST_CASE("gravity: free finds a wrong length, on the sphere the length stays, fixed leaves all of it") {
  const Vec3 short_g = (1 - 0.02 / kStandardGravity) * kDown;  // two standard deviations
  const AtRest free("free", short_g, true), sphere("s2", short_g, true), fixed("fixed", short_g, true);
  CHECK(free.state.g.norm() == Approx(kStandardGravity).margin(0.002));
  CHECK(std::sqrt(free.P(block::g + 2, block::g + 2)) < 0.003);
  CHECK(sphere.state.g.norm() == Approx(short_g.norm()).epsilon(1e-12));
  CHECK(fixed.state.g == short_g);
  CHECK(gravity_block(fixed.P).isZero(0));
  // What g may not take, the bias of the accelerometer and the velocity have to.
  CHECK(std::abs(free.state.b_a.z()) < 0.1 * std::abs(fixed.state.b_a.z()));
}

TEST_CASE(
    "gravity: free and on the sphere it shares a tilt with the bias of the accelerometer, fixed leaves it all to "
    "that") {
  const Vec3 tilted = exp_so3(Vec3(0, 0.02, 0)) * kDown;  // one standard deviation
  for (const std::string variant : {"free", "s2", "fixed"}) {
    CAPTURE(variant);
    const AtRest run(variant, tilted, false);
    const double off = angle(run.state.g, kDown), share = std::abs(run.state.b_a.x()) / (0.02 * kStandardGravity);
    CAPTURE(off, share);
    // At rest tilt and bias are one: the sum is known, and each takes the part its prior gives it.
    CHECK(std::abs(run.state.g.x() - run.state.b_a.x()) < 0.003);
    if (variant == "fixed") {
      CHECK(run.state.g == tilted);
      CHECK(share == Approx(1.0).margin(0.02));
    } else {
      CHECK(off < 0.013);
      CHECK(off > 0.007);
    }
  }
}

// eq. INI-4.
TEST_CASE("the covariance at the start: a world defined by the first pose, and nothing for what is not estimated") {
  using aslio::EstimatedStates;
  InitialState initial;
  initial.sigma_tilt = 0.02;
  initial.sigma_gyro_bias = 3e-4;
  initial.sigma_acc_bias = 0.2;
  initial.state.g = exp_so3(Vec3(0.3, -0.2, 0)) * kDown;
  const Vec3 up = initial.state.g.normalized();
  const Vec3 across = up.cross(Vec3::UnitX()).normalized();
  EstimatedStates nothing;
  nothing.gravity = EstimatedStates::Gravity::fixed;
  const StateMatrix least = aslio::initial_covariance(initial, nothing, 0.5);
  StateVector diagonal = StateVector::Zero();
  diagonal.segment<3>(block::theta).setConstant(1e-8);
  diagonal.segment<3>(block::p).setConstant(1e-8);
  diagonal.segment<3>(block::v).setConstant(0.25);
  diagonal.segment<3>(block::b_w).setConstant(9e-8);
  diagonal.segment<3>(block::b_a).setConstant(0.04);
  CHECK((least - StateMatrix(diagonal.asDiagonal())).cwiseAbs().maxCoeff() < 1e-15);

  EstimatedStates all;
  all.gyro_calibration = EstimatedStates::GyroCalibration::full;
  all.time_offset = true;
  const auto along = [&](const StateMatrix& P, const Vec3& axis) { return axis.dot(gravity_block(P) * axis); };
  const StateMatrix sphere = aslio::initial_covariance(initial, all, 0.5);
  CHECK(along(sphere, across) == Approx(std::pow(0.02 * kStandardGravity, 2)));
  CHECK(std::abs(along(sphere, up)) < 1e-15);
  all.gravity = EstimatedStates::Gravity::free;
  CHECK(along(aslio::initial_covariance(initial, all, 0.5), up) == Approx(1e-4));
  all.sigma_gravity = 0.03;
  const StateMatrix free = aslio::initial_covariance(initial, all, 0.5);
  CHECK(along(free, up) == Approx(9e-4));
  CHECK(along(free, across) == Approx(along(sphere, across)));
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const int k = block::s + 3 * column + row;
      CHECK(std::sqrt(free(k, k)) == Approx(row == column ? 0.01 : 0.005));
    }
  }
  CHECK(std::sqrt(free(block::d, block::d)) == Approx(0.003));
  all.gyro_calibration = EstimatedStates::GyroCalibration::diagonal;
  const StateMatrix scales = aslio::initial_covariance(initial, all, 0.5);
  CHECK(std::sqrt(scales(block::s + 4, block::s + 4)) == Approx(0.01));
  CHECK(scales(block::s + 1, block::s + 1) == 0);

  all.gyro_calibration = EstimatedStates::GyroCalibration::full;
  all.sigma_gyro_scale = 0.002;
  all.sigma_gyro_cross = 0.001;
  all.sigma_time_offset = 0.0005;
  const StateMatrix calibrated = aslio::initial_covariance(initial, all, 0.5);
  CHECK(std::sqrt(calibrated(block::s + 4, block::s + 4)) == Approx(0.002));
  CHECK(std::sqrt(calibrated(block::s + 5, block::s + 5)) == Approx(0.001));
  CHECK(std::sqrt(calibrated(block::d, block::d)) == Approx(0.0005));

  all.sigma_gyro_sensitivity = {0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009};  // row by row
  const StateMatrix each = aslio::initial_covariance(initial, all, 0.5);
  CHECK(std::sqrt(each(block::s, block::s)) == Approx(0.001));
  CHECK(std::sqrt(each(block::s + 1, block::s + 1)) == Approx(0.004));  // of a state by columns
  CHECK(std::sqrt(each(block::s + 6, block::s + 6)) == Approx(0.003));
  all.gyro_calibration = EstimatedStates::GyroCalibration::diagonal;
  const StateMatrix three = aslio::initial_covariance(initial, all, 0.5);
  CHECK(std::sqrt(three(block::s + 8, block::s + 8)) == Approx(0.009));
  CHECK(three(block::s + 1, block::s + 1) == 0);
}

TEST_CASE("a gyro that is said to be calibrated is believed: one turn does not change what is known of it") {
  // eq. INI-4. The gyro reads 2 % too much.
  const auto learnt = [](const std::string& sigma) {
    Filter filter({"estimator.deskew_correction=state", "estimator.gyro_calibration=full", "estimator.noise=physical",
                   "estimator." + sigma});
    filter.build_map(1);
    const TurningRoom motion{.rate = Vec3(0, 0, 3.0), .gyro_error = Vec3(0, 0, 0.02)};
    const Update& update = filter.update(RoomWindow(kRoomEpoch, kTenth, motion, 2));
    REQUIRE(update.accepted);
    return update.state.S_w(2, 2);
  };
  CHECK(learnt("sigma_gyro_scale=0.01") == Approx(0.02).margin(0.002));
  CHECK(std::abs(learnt("sigma_gyro_scale=1e-5")) < 1e-4);
  CHECK(std::abs(learnt("sigma_gyro_sensitivity=[0.01,0.01,1e-5,0.01,0.01,1e-5,0.01,0.01,1e-5]")) < 1e-4);
  CHECK_THROWS_WITH(learnt("sigma_gyro_sensitivity=[0.01,0.01]"), Catch::Contains("must be empty or nine numbers"));
}

TEST_CASE("the times of the parts of an update are disjoint: together no more than the update took") {
  TurningRoom motion;
  motion.rate = Vec3(0, 0, 2.0);
  motion.gyro_error = Vec3(0, 0, 0.02);
  for (const std::string rule : {"rigid", "linear", "asymptotic", "state"}) {
    CAPTURE(rule);
    Filter filter({"estimator.deskew_correction=" + rule, "estimator.max_iterations=8", "estimator.converged_m=1e-9"});
    filter.build_map(1);
    for (int k = 0; k < 3; ++k) {
      const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, static_cast<std::uint32_t>(k + 2));
      const double begin = thread_cpu_seconds();
      const StageTimes& t = filter.update(room).times;
      const double total = thread_cpu_seconds() - begin;
      const double parts = t.predict + t.deskew + t.sample + t.associate + t.solve;
      CAPTURE(t.predict, t.deskew, t.sample, t.associate, t.solve, total);
      CHECK(parts <= total);
      CHECK(parts > 0.5 * total);
      for (const double part : {t.predict, t.deskew, t.associate, t.solve}) CHECK(part > 0);
    }
  }
}
