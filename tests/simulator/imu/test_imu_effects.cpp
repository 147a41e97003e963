#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/imu_model.hpp"
#include "motions.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// Neither noise nor bias nor limits.
ImuModel exact() {
  return {.gyro_noise = 0,
          .acc_noise = 0,
          .gyro_bias_walk = 0,
          .acc_bias_walk = 0,
          .initial_gyro_bias = 0,
          .initial_acc_bias = 0,
          .gyro_range = 1e9,
          .acc_range = 1e9};
}

ImuModel miscalibrated() {
  ImuModel model = exact();
  model.scale_error = 0.01;
  model.cross_axis = 0.005;
  model.g_sensitivity = 1.7797e-4;
  return model;
}

ImuCalibration calibration(const Motion& motion, const ImuModel& model, std::uint64_t seed) {
  return ImuSimulator(motion, 0, model, seed).calibration();
}

/// What a sensor adds to a motion: measured = [matrix of rate | matrix of force | constant] (w, f, 1), by least
/// squares.
struct Regression {
  Eigen::Matrix<double, 7, 3> gyro, acc;    ///< transposed
  Eigen::Matrix<double, 7, 1> uncertainty;  ///< standard deviation per unit of noise

  Regression(const ImuRecord& measured, const ImuRecord& truth) {
    const auto n = static_cast<Eigen::Index>(measured.samples.size());
    Eigen::Matrix<double, Eigen::Dynamic, 7> input(n, 7);
    Eigen::Matrix<double, Eigen::Dynamic, 3> w(n, 3), f(n, 3);
    for (Eigen::Index k = 0; k < n; ++k) {
      const ImuSample &m = measured.samples[static_cast<std::size_t>(k)],
                      &t = truth.samples[static_cast<std::size_t>(k)];
      input.row(k) << t.gyro.transpose(), t.acc.transpose(), 1;
      w.row(k) = m.gyro.transpose();
      f.row(k) = m.acc.transpose();
    }
    const Eigen::Matrix<double, 7, 7> normal = input.transpose() * input;
    const auto solver = normal.ldlt();
    gyro = solver.solve(input.transpose() * w);
    acc = solver.solve(input.transpose() * f);
    uncertainty = normal.inverse().diagonal().cwiseSqrt();
  }
  Mat3 rate_by_rate() const { return gyro.topRows<3>().transpose(); }
  Mat3 rate_by_force() const { return gyro.middleRows<3>(3).transpose(); }
  Mat3 force_by_rate() const { return acc.topRows<3>().transpose(); }
  Mat3 force_by_force() const { return acc.middleRows<3>(3).transpose(); }
};

bool same_bits(const ImuRecord& a, const ImuRecord& b) {
  return std::equal(a.samples.begin(), a.samples.end(), b.samples.begin(), b.samples.end(),
                    [](auto& s, auto& t) { return s.t == t.t && s.gyro == t.gyro && s.acc == t.acc; }) &&
         a.gyro_bias == b.gyro_bias && a.acc_bias == b.acc_bias;
}

}  // namespace

TEST_CASE("scale, cross-axis and g-sensitivity are recovered exactly without noise", "[imu]") {
  const Walk walk = test::rich();
  const ImuRecord truth = simulate_imu(walk, 0, 60, exact(), 1);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ImuCalibration c = calibration(walk, miscalibrated(), seed);
    const Regression found(simulate_imu(walk, 0, 60, miscalibrated(), seed), truth);
    CHECK((found.rate_by_rate() - c.gyro_sensitivity).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((found.rate_by_force() - c.g_sensitivity).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((found.force_by_force() - c.acc_sensitivity).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(found.force_by_rate().cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("scale, cross-axis and g-sensitivity are recovered from noisy samples as well as the noise allows", "[imu]") {
  const Walk walk = test::rich();
  ImuModel model = miscalibrated();
  model.gyro_noise = 2.4435e-4;
  model.acc_noise = 1.716e-3;
  const ImuCalibration c = calibration(walk, model, 1);
  const Regression found(simulate_imu(walk, 0, 60, model, 1), simulate_imu(walk, 0, 60, exact(), 1));
  const double gyro_sd = model.gyro_noise * std::sqrt(model.rate), acc_sd = model.acc_noise * std::sqrt(model.rate);
  for (int axis = 0; axis < 3; ++axis) {
    for (int in = 0; in < 3; ++in) {
      const double by_rate = found.uncertainty[in], by_force = found.uncertainty[3 + in];
      CHECK(std::abs(found.rate_by_rate()(axis, in) - c.gyro_sensitivity(axis, in)) < 4 * gyro_sd * by_rate);
      CHECK(std::abs(found.rate_by_force()(axis, in) - c.g_sensitivity(axis, in)) < 4 * gyro_sd * by_force);
      CHECK(std::abs(found.force_by_force()(axis, in) - c.acc_sensitivity(axis, in)) < 4 * acc_sd * by_force);
    }
    // The motion tells a scale error of 0.2 % from none.
    CHECK(4 * gyro_sd * found.uncertainty[axis] < 0.002);
    CHECK(4 * acc_sd * found.uncertainty[3 + axis] < 0.002);
  }
}

TEST_CASE("calibration terms are uniform up to their bounds", "[imu]") {
  const Walk walk = test::standing();
  Mat3 largest_gyro = Mat3::Zero(), largest_acc = Mat3::Zero(), largest_g = Mat3::Zero();
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const ImuCalibration c = calibration(walk, miscalibrated(), seed);
    largest_gyro = largest_gyro.cwiseMax((c.gyro_sensitivity - Mat3::Identity()).cwiseAbs());
    largest_acc = largest_acc.cwiseMax((c.acc_sensitivity - Mat3::Identity()).cwiseAbs());
    largest_g = largest_g.cwiseMax(c.g_sensitivity.cwiseAbs());
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double bound = row == column ? 0.01 : 0.005;
      for (const Mat3* m : {&largest_gyro, &largest_acc}) {
        CHECK((*m)(row, column) <= bound * (1 + 1e-12));
        CHECK((*m)(row, column) > 0.9 * bound);
      }
      CHECK(largest_g(row, column) <= 1.7797e-4);
      CHECK(largest_g(row, column) > 0.9 * 1.7797e-4);
    }
  }
}

TEST_CASE("one effect switched off leaves the draws of the others", "[imu]") {
  const Walk walk = test::rich();
  const ImuCalibration all = calibration(walk, miscalibrated(), 5);
  ImuModel model = miscalibrated();
  model.scale_error = 0;
  const ImuCalibration no_scale = calibration(walk, model, 5);
  CHECK(no_scale.gyro_sensitivity.diagonal() == Vec3::Ones());
  CHECK(no_scale.gyro_sensitivity(0, 1) == all.gyro_sensitivity(0, 1));
  CHECK(no_scale.acc_sensitivity(2, 1) == all.acc_sensitivity(2, 1));
  CHECK(no_scale.g_sensitivity == all.g_sensitivity);
  model = miscalibrated();
  model.cross_axis = 0;
  const ImuCalibration no_cross = calibration(walk, model, 5);
  CHECK(no_cross.acc_sensitivity == Mat3(all.acc_sensitivity.diagonal().asDiagonal()));
  CHECK(no_cross.g_sensitivity == all.g_sensitivity);

  const ImuRecord full = simulate_imu(walk, 0, 10, {}, 5);
  ImuModel quiet;
  quiet.gyro_bias_walk = quiet.gyro_noise = quiet.initial_gyro_bias = 0;
  const ImuRecord no_gyro_errors = simulate_imu(walk, 0, 10, quiet, 5);
  CHECK(no_gyro_errors.acc_bias == full.acc_bias);
  for (std::size_t k = 0; k < full.samples.size(); ++k) {
    REQUIRE(no_gyro_errors.samples[k].acc == full.samples[k].acc);
    REQUIRE(no_gyro_errors.gyro_bias[k] == Vec3::Zero());
  }
}

TEST_CASE("a delayed sample is that of the earlier motion", "[imu]") {
  const Walk walk = test::rich();
  ImuModel model = exact();
  model.rate = 500;
  const ImuRecord prompt = simulate_imu(walk, 0, 60, model, 1);
  model.delay = 0.004;
  const ImuRecord delayed = simulate_imu(walk, 0, 60, model, 1);
  double largest = 0;
  for (std::size_t k = 2; k < prompt.samples.size(); ++k) {
    REQUIRE((delayed.samples[k].gyro - prompt.samples[k - 2].gyro).norm() < 1e-9);
    REQUIRE((delayed.samples[k].acc - prompt.samples[k - 2].acc).norm() < 1e-7);
    REQUIRE(delayed.samples[k].t == prompt.samples[k].t);
    largest = std::max(largest, (delayed.samples[k].gyro - prompt.samples[k].gyro).norm());
  }
  CHECK(largest > 0.01);
  // Before the start the motion is at rest.
  CHECK(delayed.samples[0].gyro.norm() < 1e-12);
  CHECK((delayed.samples[0].acc - Vec3(0, 0, kStandardGravity)).norm() < 1e-9);
}

TEST_CASE("samples are clipped after everything else", "[imu]") {
  const Walk walk = test::rich();
  ImuModel model = miscalibrated();
  model.gyro_noise = 2.4435e-4;
  model.acc_noise = 1.716e-3;
  model.initial_gyro_bias = 8.7e-3;
  const ImuRecord open = simulate_imu(walk, 0, 60, model, 2);
  model.gyro_range = 1;
  model.acc_range = 10;
  const ImuRecord clipped = simulate_imu(walk, 0, 60, model, 2);
  int at_gyro_limit = 0, at_acc_limit = 0;
  for (std::size_t k = 0; k < open.samples.size(); ++k) {
    REQUIRE(clipped.samples[k].gyro == open.samples[k].gyro.cwiseMax(-1).cwiseMin(1));
    REQUIRE(clipped.samples[k].acc == open.samples[k].acc.cwiseMax(-10).cwiseMin(10));
    at_gyro_limit += clipped.samples[k].gyro.cwiseAbs().maxCoeff() == 1;
    at_acc_limit += clipped.samples[k].acc.cwiseAbs().maxCoeff() == 10;
  }
  CHECK(at_gyro_limit > 100);
  CHECK(at_acc_limit > 100);
}

TEST_CASE("the bias is added after the sensitivity", "[imu]") {
  const Walk walk = test::standing();
  ImuModel model = miscalibrated();
  model.initial_gyro_bias = 8.7e-3;
  model.initial_acc_bias = 0.196;
  ImuSimulator imu(walk, 0, model, 3);
  const ImuSimulator::Output first = imu.next();
  const Vec3 up(0, 0, kStandardGravity);
  CHECK((first.sample.gyro - imu.calibration().g_sensitivity * up - first.gyro_bias).norm() < 1e-12);
  CHECK((first.sample.acc - imu.calibration().acc_sensitivity * up - first.acc_bias).norm() < 1e-12);
  CHECK(first.gyro_bias.norm() > 1e-4);
}

TEST_CASE("equal seeds give equal bits, and one by one the same as at once", "[imu]") {
  const Walk walk = test::rich();
  ImuModel model;
  model.scale_error = 0.01;
  model.delay = 0.002;
  const ImuRecord a = simulate_imu(walk, kSecond, 20, model, 7), b = simulate_imu(walk, kSecond, 20, model, 7);
  CHECK(same_bits(a, b));
  CHECK_FALSE(same_bits(a, simulate_imu(walk, kSecond, 20, model, 8)));
  REQUIRE(a.samples.size() == 4001);
  ImuSimulator imu(walk, kSecond, model, 7);
  ImuRecord stepwise;
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    const ImuSimulator::Output out = imu.next();
    stepwise.samples.push_back(out.sample);
    stepwise.gyro_bias.push_back(out.gyro_bias);
    stepwise.acc_bias.push_back(out.acc_bias);
  }
  CHECK(same_bits(a, stepwise));
}
