#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/analytic_world.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kDeg = std::numbers::pi / 180;

const AnalyticWorld& world() {
  static const AnalyticWorld instance;
  return instance;
}

}  // namespace

TEST_CASE("velocity, acceleration and angular rate are the derivatives of position, velocity and attitude") {
  for (const double scale : {1.0, 1.7}) {
    Options options;
    options.duration_scale = scale;
    const AnalyticWorld w(options);
    constexpr TimeNs h = 100'000;
    double velocity = 0, acceleration = 0, rate = 0;
    for (TimeNs t = w.begin_time() + 7'000'000; t < w.end_time(); t += 13'700'000) {
      const MotionState a = w.motion(t - h), m = w.motion(t), b = w.motion(t + h);
      const double step = to_seconds(2 * h);
      velocity = std::max(velocity, ((b.p - a.p) / step - m.v).norm());
      acceleration = std::max(acceleration, ((b.v - a.v) / step - m.a).norm());
      rate = std::max(rate, (log_so3(a.R.transpose() * b.R) / step - m.w).norm());
      REQUIRE((m.R.transpose() * m.R - Mat3::Identity()).norm() < 1e-14);
    }
    CHECK(velocity < 1e-5);
    CHECK(acceleration < 1e-4);
    CHECK(rate < 1e-4);
  }
}

TEST_CASE("acceleration and turn rate have no jumps, not even in their derivative") {
  // Second differences of a function with a continuous derivative shrink with the square of the step; a kink shows as
  // a difference that shrinks only in proportion to it. All joints of the motion lie on this grid.
  const auto largest = [](TimeNs h) {
    double acceleration = 0, rate = 0;
    for (TimeNs t = world().begin_time(); t < world().end_time(); t += 1'000'000) {
      const MotionState a = world().motion(t - h), m = world().motion(t), b = world().motion(t + h);
      acceleration = std::max(acceleration, (b.a - 2 * m.a + a.a).norm());
      rate = std::max(rate, (b.w - 2 * m.w + a.w).norm());
    }
    return std::pair(acceleration, rate);
  };
  const auto [acceleration, rate] = largest(2'000'000);
  const auto [finer_acceleration, finer_rate] = largest(500'000);
  CHECK(acceleration / finer_acceleration == Approx(16).epsilon(0.1));
  CHECK(rate / finer_rate == Approx(16).epsilon(0.1));
}

TEST_CASE("the walk starts at the origin, ends where it began, and stands still at both ends") {
  const Pose start = world().pose(world().begin_time()), end = world().pose(world().end_time());
  CHECK((end.p - start.p).norm() < 1e-9);
  CHECK(log_so3(start.R.transpose() * end.R).norm() < 1e-9);
  CHECK(start.p.norm() < 1e-12);
  CHECK((start.R - Mat3::Identity()).norm() < 1e-12);
  for (const TimeNs t : {world().begin_time(), world().end_time() - kSecond})
    for (TimeNs d = 0; d <= kSecond; d += kSecond / 50) {
      const MotionState m = world().motion(t + d);
      REQUIRE(m.v.norm() < 1e-12);
      REQUIRE(m.w.norm() < 1e-12);
    }
}

TEST_CASE("three turns of 90 deg are sharp, and the walk is a walk") {
  int sharp = 0;
  double peak = 0, speed = 0, length = 0;
  TimeNs began = 0;
  bool turning = false;
  for (TimeNs t = world().begin_time(); t < world().end_time(); t += 1'000'000) {
    const MotionState m = world().motion(t);
    speed = std::max(speed, m.v.norm());
    length += m.v.norm() * 1e-3;
    // Left turns only: the look into the second room begins with a right turn of its own.
    const bool now = m.w.z() > 0.1;
    if (now && !turning) {
      began = t;
      peak = 0;
    }
    if (now) peak = std::max(peak, m.w.z());
    if (!now && turning && to_seconds(t - began) < 0.7) {
      const Mat3 turned = world().motion(began).R.transpose() * m.R;
      if (std::abs(log_so3(turned).norm() - 90 * kDeg) < 3 * kDeg) {
        ++sharp;
        CHECK(peak > 180 * kDeg);
        CHECK(peak < 300 * kDeg);
      }
    }
    turning = now;
  }
  CHECK(sharp == 3);
  CHECK(speed < 2.5);
  CHECK(length > 15);
}

TEST_CASE("the person with the sensor does not walk through walls") {
  Options options;
  options.people = true;
  const AnalyticWorld crowded(options);
  for (TimeNs t = crowded.begin_time(); t <= crowded.end_time(); t += 10'000'000) {
    REQUIRE(crowded.scene().clearance(crowded.pose(t).p) > 0.4);
    REQUIRE(BoxScene(crowded.people(t)).clearance(crowded.pose(t).p) > 0.2);
  }
  CHECK(world().people(world().begin_time()).empty());
}

TEST_CASE("truth is the motion at 200 Hz") {
  const Trajectory truth = world().truth();
  CHECK(truth.size() == 4001);
  CHECK(truth.begin_time() == world().begin_time());
  CHECK(truth.end_time() == world().end_time());
  for (std::size_t i = 0; i < truth.size(); i += 100)
    CHECK((truth.samples()[i].T.p - world().pose(truth.samples()[i].t).p).norm() == 0);
}

TEST_CASE("options out of range are refused by name") {
  Options options;
  options.duration_scale = 0;
  CHECK_THROWS_WITH(AnalyticWorld(options), "duration_scale is 0, must be in [0.5, 100]");
  options.duration_scale = std::nan("");
  CHECK_THROWS_AS(AnalyticWorld(options), ConfigError);
  options.duration_scale = 1;
  options.imu_rate = 1;
  CHECK_THROWS_WITH(AnalyticWorld(options), "imu_rate is 1, must be in [20, 10000]");
}
