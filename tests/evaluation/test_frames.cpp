// eq. FRM-1, FRM-2, FRM-3, FRM-4, FRM-5, FRM-7.
#include <catch2/catch.hpp>

#include "aslio/core/angles.hpp"
#include "aslio/evaluation/force_fit.hpp"
#include "aslio/evaluation/hand_eye.hpp"
#include "aslio/evaluation/point_fit.hpp"
#include "aslio/evaluation/rotation_fit.hpp"
#include "evaluation/swinging_body.hpp"

using namespace aslio;
using namespace aslio::evaluation;
using test::body;
using test::imu_of;
using test::lidar_of;
using test::Swing;

namespace {

const Pose kMount{exp_so3(Vec3(0.3, -1.2, 0.7)), Vec3(0.05, -0.12, 0.2)};  // T_I_L
constexpr TimeNs kGap = 50'000'000;

std::vector<ImuSample> later(std::vector<ImuSample> imu, double seconds) {
  for (ImuSample& s : imu) s.t += to_ns(seconds);
  return imu;
}

RotationFit fit_of(const MotionStretch& lidar, const std::vector<ImuSample>& imu, RotationFitOptions options = {}) {
  options.expected = kMount.R.transpose();
  return fit_rotation(std::vector{lidar}, GyroTurns(imu, kGap), options);
}

double angle_between(const Mat3& a, const Mat3& b) { return log_so3(a.transpose() * b).norm(); }

}  // namespace

TEST_CASE("a gyro turns as the body does") {
  const auto imu = imu_of(0, 3);
  const GyroTurns gyro(imu, kGap);
  const auto turn = gyro.turn(to_ns(0.503), to_ns(1.7));
  REQUIRE(turn);
  const Vec3 truth = log_so3(body(0.503).R.transpose() * body(1.7).R);
  CHECK((*turn - truth).norm() < 1e-4);  // the rule of trapezia at 200 Hz
  CHECK_FALSE(gyro.turn(to_ns(2.5), to_ns(3.1)));
  CHECK_FALSE(gyro.turn(to_ns(-0.1), to_ns(1)));
}

TEST_CASE("no turn reaches over a gap of the gyro") {
  auto imu = imu_of(0, 3);
  imu.erase(imu.begin() + 200, imu.begin() + 240);  // 1.0 to 1.2 s
  const GyroTurns gyro(imu, kGap);
  CHECK(gyro.turn(to_ns(0.2), to_ns(0.9)));
  CHECK(gyro.turn(to_ns(1.3), to_ns(2.0)));
  CHECK_FALSE(gyro.turn(to_ns(0.9), to_ns(1.3)));
}

TEST_CASE("rotation, delay and bias of a gyro are found exactly without noise") {
  auto imu = later(imu_of(0, 30), 0.005);
  for (ImuSample& s : imu) s.gyro += Vec3(0.004, -0.003, 0.002);
  const RotationFit fit = fit_of(lidar_of(1, 29, kMount), imu);
  REQUIRE(fit.problem.empty());
  CHECK(angle_between(fit.R_A_B, kMount.R.transpose()) < 0.01 * kRadPerDeg);
  CHECK(fit.delay == Approx(0.005).margin(1e-4));
  CHECK((fit.bias - Vec3(0.004, -0.003, 0.002)).norm() < 5e-4);
  CHECK(fit.signs == Vec3::Ones());
  CHECK(fit.correlation > 0.99);
}

TEST_CASE("deviations that a rotation and a delay claim hold over seeds") {
  double turns = 0, delays = 0;
  constexpr int kSeeds = 24;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto s = static_cast<std::uint64_t>(seed);
    const RotationFit fit = fit_of(lidar_of(1, 41, kMount, {}, 1, 100 + s), imu_of(0, 42, {}, 1, 500 + s));
    REQUIRE(fit.problem.empty());
    const Vec3 off = log_so3(fit.R_A_B * kMount.R);
    turns += off.dot(fit.covariance.inverse() * off) / 3;
    delays += fit.delay * fit.delay / (fit.sigma_delay * fit.sigma_delay);
  }
  // Of 24 seeds chi^2 / n is within 1 +- 0.6 in 999 of 1000 cases; the jackknife leans to the safe side.
  CHECK(turns / kSeeds > 0.4);
  CHECK(turns / kSeeds < 1.6);
  CHECK(delays / kSeeds > 0.3);
  CHECK(delays / kSeeds < 2.0);
}

TEST_CASE("an axis of the gyro that is reversed is named") {
  const MotionStretch lidar = lidar_of(1, 29, kMount, {}, 1);
  for (int pattern = 1; pattern < 8; ++pattern) {
    const Vec3 signs((pattern & 1) != 0 ? -1 : 1, (pattern & 2) != 0 ? -1 : 1, (pattern & 4) != 0 ? -1 : 1);
    auto imu = imu_of(0, 30, {}, 1);
    for (ImuSample& s : imu) s.gyro = signs.cwiseProduct(s.gyro);
    const RotationFit fit = fit_of(lidar, imu);
    INFO("pattern " << pattern << ": " << fit.problem);
    REQUIRE(fit.problem.empty());
    CHECK(fit.signs == signs);
    CHECK(angle_between(fit.R_A_B, kMount.R.transpose()) < 0.3 * kRadPerDeg);
  }
}

TEST_CASE("a mounting that is wrong by 90 degrees is a rotation, not a sign") {
  RotationFitOptions options;
  const Pose wrong{kMount.R * exp_so3(Vec3(0, 0, M_PI / 2)), kMount.p};
  const RotationFit fit = fit_of(lidar_of(1, 29, wrong, {}, 1), imu_of(0, 30, {}, 1), options);
  REQUIRE(fit.problem.empty());
  CHECK(fit.signs == Vec3::Ones());
  CHECK(angle_between(fit.R_A_B, wrong.R.transpose()) < 0.3 * kRadPerDeg);
}

TEST_CASE("a stamp that is off by a sweep is a delay of a sweep") {
  const RotationFit fit = fit_of(lidar_of(1, 29, kMount, {}, 1), later(imu_of(0, 30, {}, 1), -0.1));
  REQUIRE(fit.problem.empty());
  CHECK(std::abs(fit.delay + 0.1) < 4 * fit.sigma_delay + 1e-4);
}

TEST_CASE("a rotation about the only axis that turns stays open, and what is open says so") {
  const Swing yaw{Vec3(0, 0, 0.6), 1.0};
  const RotationFit fit = fit_of(lidar_of(1, 39, kMount, yaw, 1), imu_of(0, 40, yaw, 1));
  REQUIRE(fit.problem.empty());
  const Mat3 in_imu = kMount.R * fit.covariance * kMount.R.transpose();
  CHECK(std::sqrt(in_imu(2, 2)) > 3 * kRadPerDeg);
  CHECK(std::sqrt(in_imu(0, 0)) < 0.5 * kRadPerDeg);
  CHECK(fit.signs == Vec3::Ones());
}

TEST_CASE("what is no measurement of the same turns is said to be none") {
  const MotionStretch lidar = lidar_of(1, 29, kMount, {}, 1);
  SECTION("another signal") {
    auto imu = imu_of(0, 30);
    test::Noise noise(9);
    for (ImuSample& s : imu) s.gyro = Vec3(0.4, 0.1, 0.2) + noise.vector(0.05);
    const RotationFit fit = fit_of(lidar, imu);
    CHECK_THAT(fit.problem, Catch::Contains("nothing in common"));
    CHECK(fit.unlike);
  }
  SECTION("degrees taken for radians") {
    auto imu = imu_of(0, 30);
    for (ImuSample& s : imu) s.gyro *= kDegPerRad / 10;  // 5.7 times too large: turns of windows stay below pi
    const RotationFit fit = fit_of(lidar, imu);
    CHECK_THAT(fit.problem, Catch::Contains("factor of 5.7"));
    CHECK(fit.unlike);
  }
  SECTION("no motion") {
    const Swing still{Vec3::Zero(), 0.0};
    const RotationFit fit = fit_of(lidar_of(1, 29, kMount, still, 1), imu_of(0, 30, still, 1));
    CHECK_THAT(fit.problem, Catch::Contains("hardly turns"));
    CHECK_FALSE(fit.unlike);
  }
  SECTION("too short") {
    CHECK_THAT(fit_of(lidar_of(1, 3, kMount), imu_of(0, 5)).problem, Catch::Contains("too short"));
  }
}

TEST_CASE("poses of windows are compared with means over windows") {
  MotionStretch lidar = lidar_of(1, 29, kMount);
  for (StampedPose& pose : lidar.poses) {
    // The mean of the motion over 0.2 s, as points of such a window give it.
    Vec3 turn = Vec3::Zero(), p = Vec3::Zero();
    const double t = to_seconds(pose.t);
    const Pose at = body(t) * kMount;
    for (int i = -10; i <= 10; ++i) {
      const Pose near = body(t + 0.01 * i * 20 / 21) * kMount;
      turn += log_so3(at.R.transpose() * near.R) / 21;
      p += near.p / 21;
    }
    pose.T = {at.R * exp_so3(turn), p};
  }
  const auto imu = imu_of(0, 30);
  const double rms_blind = fit_of(lidar, imu).rms;
  lidar.window = to_ns(0.2);
  CHECK(fit_of(lidar, imu).rms < 0.25 * rms_blind);
}

TEST_CASE("a hand-eye fit finds the pose between two that measure poses") {
  Trajectory reference;
  for (double t = 0; t < 42; t += 0.01) reference.append({to_ns(t + 0.008), body(t)});
  HandEyeOptions options;
  options.start = kMount.R * exp_so3(Vec3(0.05, 0.02, -0.04));
  double turns = 0, shifts = 0;
  constexpr int kSeeds = 16;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto lidar = lidar_of(1, 41, kMount, {}, 1, 300 + static_cast<std::uint64_t>(seed));
    const HandEye fit = fit_hand_eye(std::vector{lidar}, reference, options);
    REQUIRE(fit.problem.empty());
    const Vec3 turn = log_so3(fit.T_B_A.R * kMount.R.transpose()), shift = fit.T_B_A.p - kMount.p;
    CHECK(shift.norm() < 0.02);
    CHECK(std::abs(fit.delay - 0.008) < 4 * fit.sigma_delay);
    CHECK(fit.rms < fit.rms_expected);
    turns += turn.dot(fit.covariance.topLeftCorner<3, 3>().inverse() * turn) / 3;
    shifts += shift.dot(fit.covariance.bottomRightCorner<3, 3>().inverse() * shift) / 3;
  }
  CHECK(turns / kSeeds > 0.3);
  CHECK(turns / kSeeds < 1.7);
  CHECK(shifts / kSeeds > 0.3);
  CHECK(shifts / kSeeds < 1.7);
}

TEST_CASE("a hand-eye fit leaves the lever arm along the only axis of turn open") {
  const Swing yaw{Vec3(0, 0, 0.6), 1.0};
  Trajectory reference;
  for (double t = 0; t < 42; t += 0.01) reference.append({to_ns(t), body(t, yaw)});
  HandEyeOptions options;
  options.start = kMount.R;
  options.expected = {kMount.R, Vec3(0.05, -0.12, 0.5)};
  const HandEye fit = fit_hand_eye(std::vector{lidar_of(1, 41, kMount, yaw, 1)}, reference, options);
  REQUIRE(fit.problem.empty());
  CHECK(std::sqrt(fit.covariance(5, 5)) > 0.3);
  CHECK(std::sqrt(fit.covariance(3, 3)) < 0.03);
}

namespace {

ForceFit force_of(const std::vector<ImuSample>& imu, std::uint64_t seed = 2) {
  ForceFitOptions options;
  options.R_I_A = kMount.R;
  return fit_force(std::vector{lidar_of(1, 61, kMount, {}, 1, seed)}, imu, options);
}

}  // namespace

TEST_CASE("the accelerometer tells where the LiDAR is, as well as it claims") {
  double shifts = 0;
  constexpr int kSeeds = 16;
  const auto imu = imu_of(0, 62, {}, 1);
  for (int seed = 0; seed < kSeeds; ++seed) {
    const ForceFit fit = force_of(imu, 700 + static_cast<std::uint64_t>(seed));
    REQUIRE(fit.problem.empty());
    const Vec3 off = fit.lever - kMount.p;
    CHECK(off.norm() < 0.03);
    CHECK(std::abs(fit.gravity - kStandardGravity) < 4 * fit.sigma_gravity);
    CHECK(fit.sigma_gravity < 0.5);
    CHECK(fit.signs == Vec3::Ones());
    shifts += off.dot(fit.covariance.inverse() * off) / 3;
  }
  CHECK(shifts / kSeeds > 0.2);
  CHECK(shifts / kSeeds < 1.7);
}

TEST_CASE("a reversed axis of the accelerometer is named") {
  for (int axis = 0; axis < 3; ++axis) {
    auto imu = imu_of(0, 62, {}, 1);
    for (ImuSample& s : imu) s.acc[axis] *= -1;
    Vec3 signs = Vec3::Ones();
    signs[axis] = -1;
    const ForceFit fit = force_of(imu);
    REQUIRE(fit.problem.empty());
    CHECK(fit.signs == signs);
    CHECK(fit.gravity == Approx(kStandardGravity).margin(0.5));
  }
  auto imu = imu_of(0, 62, {}, 1);
  for (ImuSample& s : imu) s.acc *= -1;
  CHECK(force_of(imu).signs == Vec3(-1, -1, -1));
}

TEST_CASE("gravity that was taken out is missing") {
  auto imu = imu_of(0, 62);
  for (ImuSample& s : imu) s.acc -= body(to_seconds(s.t)).R.transpose() * Vec3(0, 0, kStandardGravity);
  const ForceFit fit = force_of(imu);
  REQUIRE(fit.problem.empty());
  CHECK(fit.gravity < 0.1);
}

TEST_CASE("positions of a point tell where it sits, as well as they claim") {
  const Vec3 point(-0.3, 0.1, 0.4);  // in I
  const Vec3 truth = kMount.inverse() * point;
  double shifts = 0;
  constexpr int kSeeds = 16;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto s = static_cast<std::uint64_t>(seed);
    test::Noise noise(900 + s);
    Trajectory positions;
    for (double t = 0; t < 92; t += 0.05) {
      positions.append({to_ns(t + 0.02), Pose{Mat3::Identity(), body(t) * point + noise.vector(0.005)}});
    }
    const PointFit fit = fit_point(std::vector{lidar_of(1, 91, kMount, {}, 1, 800 + s)}, positions, {});
    REQUIRE(fit.problem.empty());
    const Vec3 off = fit.point - truth;
    CHECK(off.norm() < 0.02);
    CHECK(std::abs(fit.delay - 0.02) < 4 * fit.sigma_delay + 1e-3);
    shifts += off.dot(fit.covariance.inverse() * off) / 3;
  }
  CHECK(shifts / kSeeds > 0.2);
  CHECK(shifts / kSeeds < 2.0);
}
