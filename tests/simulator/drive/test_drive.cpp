#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/imu_params.hpp"
#include "roads.hpp"
#include "simulator/motion/smoothness.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;
using Catch::Matchers::Contains;

namespace {

/// What dead reckoning by Runge-Kutta on the IMU's exact samples misses at the end [m].
double reckoning_error(const Motion& motion, double rate) {
  ImuParams params;
  params.preset = ImuPreset::perfect;
  params.gyro_noise = params.acc_noise = 0;
  params.rate = 2 * rate;
  const double duration = std::floor(motion.duration());
  const std::vector<ImuSample> samples = simulate_imu(motion, 0, duration, imu_model(params), 1).samples;
  const MotionState start = motion.at(0);
  struct State {
    Eigen::Vector4d q;
    Vec3 p, v;
  } s{Eigen::Quaterniond(start.R).coeffs(), start.p, start.v};
  const auto slope = [](const State& at, const ImuSample& imu) {
    const Eigen::Quaterniond q(at.q), w(0, imu.gyro.x(), imu.gyro.y(), imu.gyro.z());
    return State{0.5 * (q * w).coeffs(), at.v, q.normalized() * imu.acc - Vec3(0, 0, kStandardGravity)};
  };
  const auto moved = [](const State& at, double h, const State& d) {
    return State{at.q + h * d.q, at.p + h * d.p, at.v + h * d.v};
  };
  const double h = 1 / rate;
  for (std::size_t k = 2; k < samples.size(); k += 2) {
    const State a = slope(s, samples[k - 2]), b = slope(moved(s, h / 2, a), samples[k - 1]);
    const State c = slope(moved(s, h / 2, b), samples[k - 1]), d = slope(moved(s, h, c), samples[k]);
    s = moved(moved(moved(moved(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    s.q.normalize();
  }
  return (s.p - motion.at(duration).p).norm();
}

}  // namespace

TEST_CASE("a drive has exact derivatives and is three times continuously differentiable", "[drive]") {
  const Drive drive(bent_road(), hills(), stop_and_go(), 3);
  const DerivativeErrors errors = derivative_errors(drive, 7.3e-3);
  CHECK(errors.velocity < 1e-6);
  CHECK(errors.acceleration < 2e-5);
  CHECK(errors.rate < 2e-6);
  CHECK(errors.rotation < 1e-14);
  const LargestChanges coarse = largest_changes(drive, 2e-3), fine = largest_changes(drive, 2e-4);
  CHECK(fine.jerk < 0.15 * coarse.jerk);
  CHECK(fine.rate_curvature < 0.15 * coarse.rate_curvature);
}

TEST_CASE("the IMU of a drive leads back to the drive", "[drive]") {
  const Drive drive(bent_road(), hills(), stop_and_go(), 3);
  REQUIRE(drive.duration() > 40);
  CHECK(reckoning_error(drive, 1000) < 1e-3);
}

TEST_CASE("a drive keeps to its limits of speed and acceleration", "[drive]") {
  const RoadLine road = bent_road();
  DriveParams params = stop_and_go();
  params.roughness = 0;
  params.suspension = 0;
  const Drive drive(road, Ground{}, params, 1);
  double top = 0, along = 0, across = 0, slowest_in_bend = 100;
  for (double t = 0; t < drive.duration(); t += 0.01) {
    const MotionState m = drive.at(t);
    const Vec3 a = m.R.transpose() * m.a, v = m.R.transpose() * m.v;
    REQUIRE(std::abs(v.y()) < 1e-9);
    REQUIRE(v.x() > -1e-9);
    REQUIRE(v.x() == Approx(drive.speed(t)).margin(1e-9));
    top = std::max(top, v.x());
    along = std::max(along, std::abs(a.x()));
    across = std::max(across, std::abs(a.y()));
    const double share = drive.way(t) / road.length();
    if (share > 0.85 && share < 0.95) REQUIRE(v.x() < 6 + 1e-6);
    const RoadLine::Bend& bend = road.bends()[0];
    if (drive.way(t) > bend.begin && drive.way(t) < bend.begin + bend.length)
      slowest_in_bend = std::min(slowest_in_bend, v.x());
  }
  CHECK(top <= params.speed + 1e-9);
  CHECK(top > 10);
  CHECK(along <= params.acceleration + 1e-6);
  CHECK(along > 0.5 * params.acceleration);
  CHECK(across <= params.lateral_acceleration + 1e-6);
  CHECK(across > 0.95 * params.lateral_acceleration);
  // The square root of 3 m/s^2 times 12 m.
  CHECK(slowest_in_bend == Approx(6).margin(0.01));
}

TEST_CASE("a drive starts at any speed and ends at any", "[drive]") {
  const RoadLine road({{0, 0}, {900, 0}}, 100);
  for (const double speed : {0.0, 0.5, 8.0, 20.0, 35.0}) {
    CAPTURE(speed);
    DriveParams params;
    params.speed = 35;
    params.start_speed = speed;
    params.end_speed = speed;
    params.suspension = 0;
    params.roughness = 0;
    const Drive drive(road, Ground{}, params, 1);
    const MotionState begin = drive.at(0), end = drive.at(drive.duration());
    CHECK(begin.v.x() == Approx(speed).margin(1e-12));
    CHECK(end.v.x() == Approx(speed).margin(1e-9));
    CHECK(drive.way(drive.duration()) == Approx(road.length()).margin(1e-6));
    if (speed > 0) continue;
    for (double t = -1; t <= params.standstill; t += 0.1) REQUIRE(drive.at(t).v.norm() == 0);
    CHECK(drive.at(params.standstill + 3).v.norm() > 0.3);
  }
}

TEST_CASE("a drive waits where it shall", "[drive]") {
  const RoadLine road = bent_road();
  const Drive drive(road, Ground{}, stop_and_go(), 1);
  double waited = 0;
  for (double t = 0; t < drive.duration() - 3; t += 0.01)
    if (drive.speed(t) == 0) {
      waited += 0.01;
      CHECK(drive.way(t) == Approx(0.12 * road.length()).margin(1e-6));
    }
  CHECK(waited == Approx(2).margin(0.05));
}

TEST_CASE("the body pitches when the car brakes and rolls outwards in bends", "[drive]") {
  const RoadLine road = bent_road();
  DriveParams params = stop_and_go();
  params.roughness = 0;
  const Drive drive(road, Ground{}, params, 1);
  double most_pitch = 0, most_roll = 0;
  for (double t = 0; t < drive.duration(); t += 0.01) {
    const MotionState m = drive.at(t);
    const Vec3 a = m.R.transpose() * m.a;
    most_pitch = std::max(most_pitch, std::abs(std::asin(m.R(2, 0))));
    most_roll = std::max(most_roll, std::abs(std::asin(m.R(2, 1))));
    if (std::abs(a.x()) > 1) REQUIRE(m.R(2, 0) * a.x() > 0);
    if (std::abs(a.y()) > 2) REQUIRE(m.R(2, 1) * a.y() > 0);
  }
  CHECK(most_pitch > 0.3 * std::numbers::pi / 180);
  CHECK(most_pitch < 0.6 * std::numbers::pi / 180);
  CHECK(most_roll > 1.0 * std::numbers::pi / 180);
  CHECK(most_roll < 1.4 * std::numbers::pi / 180);
}

TEST_CASE("the road shakes a car that moves, and not one that stands", "[drive]") {
  const RoadLine road({{0, 0}, {900, 0}}, 100);
  DriveParams params;
  params.speed = params.start_speed = params.end_speed = 30;
  double sum = 0;
  const Drive fast(road, Ground{}, params, 1);
  for (int k = 0; k < 2500; ++k) sum += std::pow(fast.at(0.01 * k).a.z(), 2);
  CHECK(std::sqrt(sum / 2500) > 0.2);
  CHECK(std::sqrt(sum / 2500) < 0.8);
  params.start_speed = 0;
  const Drive standing(road, Ground{}, params, 1);
  CHECK(standing.at(1).a.norm() == 0);
  CHECK(standing.at(1).w.norm() == 0);
}

TEST_CASE("drives that cannot be had are refused by key", "[drive]") {
  const RoadLine road = bent_road();
  DriveParams params = stop_and_go();
  params.speed = params.start_speed = 30;
  CHECK_THROWS_WITH(Drive(road, Ground{}, params, 1), Contains("drive.start_speed") && Contains("slow down"));
  params = stop_and_go();
  const RoadLine::Bend& bend = road.bends()[0];
  params.stops = {{(bend.begin + 0.5 * bend.length) / road.length(), 1}};
  CHECK_THROWS_WITH(Drive(road, Ground{}, params, 1), Contains("drive.stops[0].at") && Contains("in a bend"));
}

TEST_CASE("a drive may end before its road", "[drive]") {
  DriveParams params = stop_and_go();
  params.duration = 9.5;
  const Drive drive(bent_road(), Ground{}, params, 1);
  CHECK(drive.duration() == 9.5);
}
