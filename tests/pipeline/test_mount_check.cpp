// Whether the corrections repeat the turn: eq. MON-7.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "aslio/core/lie.hpp"
#include "aslio/pipeline/mount_check.hpp"

using namespace aslio;
using aslio::pipeline::MountCheck;

namespace {

/// A walk: yaw of 1 rad/s, roll and pitch of 0.1 rad/s by the step; the LiDAR is claimed turned by `wrong`, and the
/// points correct `gain` of what it contradicts.
MountCheck walked(const Vec3& wrong, double gain, double noise, double dt, double seconds) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, noise);
  const Mat3 M = gain * (exp_so3(wrong) - Mat3::Identity());
  MountCheck check;
  for (double t = 0; t < seconds; t += dt) {
    const Vec3 rate(0.1 * std::sin(11 * t), 0.13 * std::cos(9 * t), 1.0 + 0.5 * std::sin(t));
    const Vec3 error(normal(random), normal(random), normal(random));
    check.add((M * rate + error) * dt, rate * dt, dt);
  }
  return check;
}

constexpr double kRight = 1.5708;

}  // namespace

TEST_CASE("mount check: a LiDAR turned by a right angle about the vertical is found by roll and pitch") {
  for (const double dt : {0.008, 0.1}) {
    const MountCheck check = walked({0, 0, kRight}, 0.6, 0.05, dt, 10);
    CAPTURE(dt, check.contradiction());
    CHECK(check.contradiction() > 1.0);
    CHECK(check.share() == Approx(0.6 * std::sqrt(2.0)).epsilon(0.25));
    CHECK(std::abs(check.axis().z()) < 0.2);
  }
}

TEST_CASE("mount check: one that lies on its side is found by the yaw") {
  const MountCheck check = walked({kRight, 0, 0}, 0.3, 0.05, 0.1, 10);
  CHECK(check.contradiction() > 1.0);
  CHECK(std::abs(check.axis().z()) > 0.8);
}

TEST_CASE("mount check: noise of the corrections, and a gyro's scale of 2 %, are no contradiction") {
  for (const double noise : {0.02, 0.1, 0.4}) {
    CHECK(walked(Vec3::Zero(), 1.0, noise, 0.1, 60).contradiction() < 0.5);
    CHECK(walked(Vec3::Zero(), 1.0, noise, 0.008, 60).contradiction() < 0.5);
  }
  CHECK(walked({0.01, 0, 0}, 1.0, 0.05, 0.1, 60).contradiction() < 0.5);
}

TEST_CASE(
    "mount check: an axis that does not turn says nothing, though the points contradict its noise and bias in full") {
  std::mt19937_64 random(8);
  std::normal_distribution<double> noise(0.0, 0.01);
  MountCheck check;
  for (double t = 0; t < 30; t += 0.1) {
    const double yaw = 0.01 + noise(random);  // of a gyro at rest, which the points take back
    const Vec3 rate(0.3 * std::sin(11 * t), 0.3 * std::cos(9 * t), yaw);
    check.add(Vec3(0, 0, -yaw) * 0.1, rate * 0.1, 0.1);
    CHECK(check.contradiction() < 0.5);
  }
}

TEST_CASE("mount check: nothing is said before five seconds, nor of a row that was interrupted") {
  CHECK(walked({0, 0, kRight}, 0.6, 0.02, 0.1, 4.5).contradiction() == 0.0);
  MountCheck check;
  for (int i = 0; i < 1000; ++i) {
    check.add(Vec3(0, 0, 0.05), Vec3(0, 0, 0.05), 0.05);
    check.interrupt();
  }
  CHECK(check.contradiction() == 0.0);
}
