// The motion over the first sweeps, found by registering them (eq. INI-6).
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "aslio/pipeline/sweep_motion.hpp"

using namespace aslio;
using namespace aslio::pipeline;

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;

struct Box {
  Vec3 low, high;
};

/// A street along x: a road, facades with recesses of uneven width, posts and parked cars at uneven distances.
std::vector<Box> street() {
  std::vector<Box> boxes = {{{-200, -60, -2.7}, {300, 60, -1.7}}};
  std::mt19937 engine(100);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(engine() % 10000) / 1e4; };
  for (const double side : {-1.0, 1.0}) {
    for (double x = -100; x < 200;) {
      const double width = uniform(4, 12), y = side * uniform(8, 11);
      boxes.push_back({{x, std::min(y, side * 40), -1.7}, {x + width, std::max(y, side * 40), uniform(4, 9)}});
      const double post = x + uniform(0, width);
      boxes.push_back({{post - 0.1, side * 6 - 0.1, -1.7}, {post + 0.1, side * 6 + 0.1, 5}});
      if (engine() % 2 == 0) boxes.push_back({{x, side * 5 - 0.9, -1.7}, {x + 4.2, side * 5 + 0.9, -0.2}});
      x += width + uniform(0, 2);
    }
  }
  return boxes;
}

/// Pillars of 0.5 m every 4 m on both sides of a road, and nothing else: speeds that differ by 40 m/s look the same.
std::vector<Box> pillars() {
  std::vector<Box> boxes = {{{-200, -60, -2.7}, {300, 60, -1.7}}};
  for (const double side : {-5.0, 7.0}) {
    for (double x = -150; x < 250; x += 4) boxes.push_back({{x, side, -1.7}, {x + 0.5, side + 0.5, 3}});
  }
  return boxes;
}

/// A room with a cupboard, seen from inside: walls as boxes.
std::vector<Box> room() {
  return {{{-2, -2, -1.6}, {-1.9, 2, 1.2}}, {{2, -2, -1.6}, {2.1, 2, 1.2}},   {{-2, -2.1, -1.6}, {2, -2, 1.2}},
          {{-2, 2, -1.6}, {2, 2.1, 1.2}},   {{-2, -2, -1.7}, {2, 2, -1.6}},   {{1.2, -1.9, -1.6}, {1.9, -1, 0.5}},
          {{-2, -2, 1.2}, {2, 2, 1.3}},     {{-1.9, 1, -1.6}, {-1.2, 1.9, 0}}};
}

double cast(const std::vector<Box>& boxes, const Vec3& from, const Vec3& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : boxes) {
    const Vec3 a = (box.low - from).cwiseQuotient(ray), b = (box.high - from).cwiseQuotient(ray);
    const double enter = a.cwiseMin(b).maxCoeff(), leave = a.cwiseMax(b).minCoeff();
    if (enter > 0 && enter < leave) nearest = std::min(nearest, enter);
  }
  return nearest;
}

/// A carrier that begins with a velocity, keeps an acceleration and turns about z.
struct Carrier {
  Vec3 v = Vec3::Zero(), a = Vec3::Zero();
  double rate = 0;
  Pose pose(double t) const { return {exp_so3(rate * t * Vec3::UnitZ()), t * v + 0.5 * t * t * a}; }
};

struct Data {
  std::vector<TimedPoint> points;
  std::vector<ImuSample> imu;
};

/// What a sensor of 16 lines at 10 Hz and an IMU of `imu_rate` measure from kEpoch on.
Data drive(const Carrier& carrier, double imu_rate, const SensorModel& sensor, const std::vector<Box>& world = street(),
           double sigma = 0.02) {
  Data data;
  const int firings = static_cast<int>(std::lround(9000 * sensor.sweep_period));
  const double span = to_seconds(sweep_motion_span(sensor)) + std::max(0.1, sensor.sweep_period);
  std::mt19937 engine(101);
  std::uint32_t index = 0;
  for (int k = 1; k <= std::lround(span * 9000); ++k) {
    const double t = k / 9000.0;
    const Pose T = carrier.pose(t) * sensor.T_imu_lidar;
    for (int line = 0; line < 16; ++line) {
      const double azimuth = 2 * std::numbers::pi * k / firings, height = (2.0 * line - 15) * std::numbers::pi / 180;
      const Vec3 ray(std::cos(azimuth) * std::cos(height), std::sin(azimuth) * std::cos(height), std::sin(height));
      double noise = -6;
      for (int i = 0; i < 12; ++i) noise += static_cast<double>(engine() % 10000) / 1e4;
      const double range = cast(world, T.p, T.R * ray) + sigma * noise;
      if (!(range < sensor.max_range)) continue;
      const Eigen::Vector3f p = (range * ray).cast<float>();
      data.points.push_back({.x = p.x(), .y = p.y(), .z = p.z(), .t = kEpoch + to_ns(t), .index = index++});
    }
  }
  for (int k = 0; imu_rate > 0 && k <= (span + 0.1) * imu_rate; ++k) {
    const double t = k / imu_rate;
    const Mat3 R = carrier.pose(t).R;
    data.imu.push_back({kEpoch + to_ns(t), Vec3(0, 0, carrier.rate + 0.003),
                        R.transpose() * (carrier.a + kStandardGravity * Vec3::UnitZ()) + Vec3(0.02, -0.03, 0.01)});
  }
  return data;
}

SensorModel car_sensor() {
  SensorModel sensor;
  sensor.T_imu_lidar = {exp_so3(Vec3(0.01, -0.02, 0.3)), Vec3(0.8, -0.3, 0.4)};
  sensor.min_range = 1.0;
  return sensor;
}

std::optional<SweepMotion> found(const Carrier& carrier, double imu_rate, const SensorModel& sensor) {
  const Data data = drive(carrier, imu_rate, sensor);
  return find_sweep_motion(data.points, data.imu, kEpoch, sensor);
}

}  // namespace

TEST_CASE("sweep motion: a rest is a rest, at any rate of the IMU and without one") {
  for (const double imu_rate : {0.0, 10.0, 200.0}) {
    const auto motion = found({}, imu_rate, car_sensor());
    REQUIRE(motion);
    CAPTURE(imu_rate, motion->velocity.transpose(), motion->fit, motion->fit_at_rest);
    CHECK_FALSE(motion->moves);
    CHECK_FALSE(motion->ambiguous);
    CHECK(motion->velocity.norm() < 0.1);
  }
}

TEST_CASE("sweep motion: an even speed is found although the IMU is calm") {
  for (const double speed : {0.7, 3.0, 11.0, 20.0, 30.0, 38.0}) {
    for (const double imu_rate : {0.0, 10.0, 200.0}) {
      const auto motion = found({.v = Vec3(speed, 0, 0)}, imu_rate, car_sensor());
      REQUIRE(motion);
      CAPTURE(speed, imu_rate, motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
      CHECK(motion->moves);
      CHECK(motion->believed);
      CHECK((motion->velocity - Vec3(speed, 0, 0)).norm() < (imu_rate > 0 ? 0.3 : 0.4));
      CHECK(motion->sigma_velocity < 0.6);
      CHECK_FALSE(motion->ambiguous);
    }
  }
}

TEST_CASE("sweep motion: braking and turning carriers, forwards and backwards") {
  for (const double speed : {-5.0, 8.0, 15.0}) {
    const Carrier carrier{.v = Vec3(speed, 0.1 * speed, 0), .a = Vec3(-3, 1, 0), .rate = 0.6};
    for (const double imu_rate : {100.0, 200.0}) {
      const auto motion = found(carrier, imu_rate, car_sensor());
      REQUIRE(motion);
      CAPTURE(speed, imu_rate, motion->velocity.transpose(), motion->gravity.transpose(), motion->fit);
      CHECK(motion->moves);
      CHECK(motion->believed);
      CHECK((motion->velocity - carrier.v).norm() < std::max(0.3, 3 * motion->sigma_velocity));
      CHECK(std::acos(std::min(1.0, -motion->gravity.normalized().z())) < 4 * motion->sigma_tilt);
    }
  }
}

TEST_CASE("sweep motion: a sensor of 50 sweeps per second is looked at for as long as one of 10") {
  SensorModel sensor = car_sensor();
  sensor.sweep_period = 0.02;
  CHECK(sweep_motion_span(sensor) == sweep_motion_span(car_sensor()));
  for (const double speed : {0.0, 3.0, 20.0}) {
    const auto motion = found({.v = Vec3(speed, 0, 0)}, 200, sensor);
    REQUIRE(motion);
    CAPTURE(speed, motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
    CHECK(motion->moves == (speed > 0));
    CHECK(motion->believed);
    CHECK((motion->velocity - Vec3(speed, 0, 0)).norm() < 0.4);
  }
}

TEST_CASE("sweep motion: in a small room a rest and a walk are told apart") {
  SensorModel sensor;
  for (const double speed : {0.0, 1.2}) {
    const Carrier carrier{.v = Vec3(speed, 0, 0)};
    const Data data = drive(carrier, 200, sensor, room());
    const auto motion = find_sweep_motion(data.points, data.imu, kEpoch, sensor);
    REQUIRE(motion);
    CAPTURE(speed, motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
    CHECK(motion->moves == (speed > 0));
    CHECK_FALSE(motion->ambiguous);
    CHECK((motion->velocity - carrier.v).norm() < 0.3);
  }
}

TEST_CASE("sweep motion: where speeds look alike, a wrong one is said to be uncertain") {
  for (const double speed : {0.0, 20.0, 28.0, 38.0}) {
    const SensorModel sensor = car_sensor();
    const Carrier carrier{.v = Vec3(speed, 0, 0)};
    const Data data = drive(carrier, 100, sensor, pillars());
    const auto motion = find_sweep_motion(data.points, data.imu, kEpoch, sensor);
    REQUIRE(motion);
    CAPTURE(speed, motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
    const bool right = (motion->velocity - carrier.v).norm() < 0.5;
    CHECK((right || motion->ambiguous));
  }
}

TEST_CASE("sweep motion: where nothing binds the motion, none is believed") {
  // A road and nothing else: every speed along it explains the sweeps, a rest among them.
  SensorModel sensor = car_sensor();
  sensor.T_imu_lidar = {};
  Data data = drive({.v = Vec3(11, 0, 0)}, 200, sensor);
  std::erase_if(data.points, [](const TimedPoint& p) { return p.z > -1.5F; });
  const auto motion = find_sweep_motion(data.points, data.imu, kEpoch, sensor);
  REQUIRE(motion);
  CAPTURE(motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
  CHECK((!motion->moves || !motion->believed));
  CHECK((!motion->believed || motion->sigma_velocity > 0.7));  // nor is it a rest
}

TEST_CASE("sweep motion: a sweep without points says nothing") {
  Data data = drive({}, 200, car_sensor());
  std::erase_if(data.points, [](const TimedPoint& p) { return p.t > kEpoch + kSecond / 4; });
  CHECK_FALSE(find_sweep_motion(data.points, data.imu, kEpoch, car_sensor()));
  CHECK_FALSE(find_sweep_motion({}, {}, kEpoch, car_sensor()));
}

TEST_CASE("sweep motion: sweeps that share little of the view prove no velocity and no rest") {
  // A view of 38 deg. In 0.3 s it turns by 17 deg, or by 138 deg out of all that the first sweep saw.
  for (const double speed : {0.0, 1.2}) {
    for (const double rate : {1.0, 8.0}) {
      const SensorModel sensor = car_sensor();
      Data data = drive({.v = Vec3(speed, 0, 0), .rate = rate}, 200, sensor);
      std::erase_if(data.points, [](const TimedPoint& p) { return p.x < 0 || std::abs(p.y) > 0.344F * p.x; });
      const auto motion = find_sweep_motion(data.points, data.imu, kEpoch, sensor);
      REQUIRE(motion);
      CAPTURE(speed, rate, motion->velocity.transpose(), motion->sigma_velocity, motion->fit, motion->fit_at_rest);
      CHECK(motion->shares == (rate < 2));
      if (!motion->shares) CHECK_FALSE(motion->believed);
    }
  }
}
