#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/analytic_world.hpp"
#include "aslio/simulator/random.hpp"

using namespace aslio;
using namespace aslio::simulator;

TEST_CASE("dead reckoning with an ideal IMU of 2 kHz reproduces the truth") {
  Options options;
  options.imu_noise = false;
  options.imu_rate = 2000;
  const AnalyticWorld world(options);
  NavState state = world.state(world.begin_time());
  double worst = 0, worst_angle = 0;
  const auto& samples = world.imu().samples;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 1], &b = samples[i];
    const double dt = to_seconds(b.t - a.t);
    const Vec3 w = 0.5 * (a.gyro + b.gyro);
    // Trapezoid over the ends' accelerations in the world.
    const Mat3 R = state.R * exp_so3(w * dt);
    const Vec3 from = state.R * a.acc + state.g, to = R * b.acc + state.g;
    state.p += state.v * dt + dt * dt * (2 * from + to) / 6;
    state.v += 0.5 * dt * (from + to);
    state.R = R;
    const Pose truth = world.pose(b.t);
    worst = std::max(worst, (state.p - truth.p).norm());
    worst_angle = std::max(worst_angle, log_so3(truth.R.transpose() * state.R).norm());
  }
  INFO("worst position error " << worst << " m, attitude " << worst_angle << " rad");
  CHECK(worst < 1e-3);
  CHECK(worst_angle < 1e-5);
}

TEST_CASE("at rest an ideal IMU feels gravity upwards and no rate") {
  Options options;
  options.imu_noise = false;
  const AnalyticWorld world(options);
  const ImuSample& first = world.imu().samples.front();
  CHECK((first.acc - Vec3(0, 0, kStandardGravity)).norm() < 1e-12);
  CHECK(first.gyro.norm() < 1e-12);
  CHECK(world.imu().samples.size() == 4001);
  CHECK(world.imu().samples[200].t == world.begin_time() + kSecond);
}

TEST_CASE("IMU noise has the specified density, and biases start and walk as specified") {
  Options noisy, ideal;
  noisy.duration_scale = ideal.duration_scale = 20;
  ideal.imu_noise = false;
  const AnalyticWorld a(noisy), b(ideal);
  const SensorModel& sensor = a.sensor();
  const auto n = static_cast<double>(a.imu().samples.size());
  Vec3 gyro = Vec3::Zero(), acc = Vec3::Zero(), gyro_walk = Vec3::Zero(), acc_walk = Vec3::Zero();
  for (std::size_t i = 0; i < a.imu().samples.size(); ++i) {
    const ImuSample &s = a.imu().samples[i], &t = b.imu().samples[i];
    gyro += (s.gyro - t.gyro - a.imu().gyro_bias[i]).cwiseAbs2() / n;
    acc += (s.acc - t.acc - a.imu().acc_bias[i]).cwiseAbs2() / n;
    if (i == 0) continue;
    gyro_walk += (a.imu().gyro_bias[i] - a.imu().gyro_bias[i - 1]).cwiseAbs2() / n;
    acc_walk += (a.imu().acc_bias[i] - a.imu().acc_bias[i - 1]).cwiseAbs2() / n;
  }
  // 80 001 samples: the estimate of a standard deviation is good to 0.25 %; 1 % is four of that.
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(std::sqrt(gyro[axis]) == Approx(2.4435e-4 * std::sqrt(200)).epsilon(0.01));
    CHECK(std::sqrt(acc[axis]) == Approx(1.716e-3 * std::sqrt(200)).epsilon(0.01));
    CHECK(std::sqrt(gyro_walk[axis] * 200) == Approx(sensor.gyro_bias_walk).epsilon(0.01));
    CHECK(std::sqrt(acc_walk[axis] * 200) == Approx(sensor.acc_bias_walk).epsilon(0.01));
  }
  double largest_gyro = 0, largest_acc = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Options options;
    options.seed = seed;
    const NavState state = AnalyticWorld(options).state(options.begin);
    largest_gyro = std::max(largest_gyro, state.b_w.cwiseAbs().maxCoeff());
    largest_acc = std::max(largest_acc, state.b_a.cwiseAbs().maxCoeff());
  }
  CHECK(largest_gyro <= 8.727e-3);
  CHECK(largest_gyro > 7e-3);
  CHECK(largest_acc <= 0.196133);
  CHECK(largest_acc > 0.15);
}

TEST_CASE("true biases belong to the sample at or before a time") {
  const AnalyticWorld world;
  const ImuRecord& imu = world.imu();
  CHECK(world.state(imu.samples[70].t + 100).b_w == imu.gyro_bias[70]);
  CHECK(world.state(imu.samples[71].t).b_a == imu.acc_bias[71]);
  CHECK(world.state(world.begin_time() - 1).b_a == imu.acc_bias.front());
  CHECK(world.state(world.end_time() + 1).b_a == imu.acc_bias.back());
}

TEST_CASE("random numbers are fixed, and streams and seeds are independent") {
  RandomStream a(1, 1), same(1, 1), other_purpose(1, 2), other_seed(2, 1);
  const double first = a.uniform();
  CHECK(first == same.uniform());
  CHECK(first != other_purpose.uniform());
  CHECK(first != other_seed.uniform());
  double mean = 0, square = 0, fourth = 0;
  constexpr int kDraws = 400'000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = a.normal();
    mean += x / kDraws;
    square += x * x / kDraws;
    fourth += x * x * x * x / kDraws;
  }
  CHECK(std::abs(mean) < 0.008);
  CHECK(square == Approx(1).epsilon(0.01));
  CHECK(fourth == Approx(3).epsilon(0.03));
}
