#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/simulator/imu_params.hpp"
#include "motions.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {
constexpr double kDegree = std::numbers::pi / 180;

ImuParams preset(ImuPreset preset, double rate) {
  ImuParams params;
  params.preset = preset;
  params.rate = rate;
  return params;
}
}  // namespace

TEST_CASE("the perfect preset does not look stuck while it stands still", "[imu]") {
  const ImuRecord record = simulate_imu(test::standing(), 0, 2, imu_model(preset(ImuPreset::perfect, 200)), 1);
  for (std::size_t k = 1; k < record.samples.size(); ++k) {
    REQUIRE(record.samples[k].gyro != record.samples[k - 1].gyro);
    REQUIRE(record.samples[k].acc != record.samples[k - 1].acc);
    REQUIRE(record.samples[k].gyro.norm() < 1e-7);
  }
}

TEST_CASE("the perfect preset without its noise measures the motion and nothing else", "[imu]") {
  const Walk walk = test::rich();
  ImuParams params = preset(ImuPreset::perfect, 1000);
  params.gyro_noise = params.acc_noise = 0;
  const ImuModel model = imu_model(params);
  const ImuRecord record = simulate_imu(walk, 0, 60, model, 1);
  REQUIRE(record.samples.size() == 60001);
  for (std::size_t k = 0; k < record.samples.size(); ++k) {
    const MotionState m = walk.at(to_seconds(record.samples[k].t));
    REQUIRE(record.samples[k].gyro == m.w);
    REQUIRE((record.samples[k].acc - m.R.transpose() * (m.a + Vec3(0, 0, kStandardGravity))).norm() < 1e-12);
    REQUIRE(record.gyro_bias[k].norm() + record.acc_bias[k].norm() == 0);
  }
}

TEST_CASE("the ideal preset is the noise of a BMI088, perfectly calibrated", "[imu]") {
  const ImuModel model = imu_model(preset(ImuPreset::ideal, 200));
  CHECK(model.rate == 200);
  CHECK(model.gyro_noise == 2.4435e-4);
  CHECK(model.acc_noise == 1.716e-3);
  CHECK(model.gyro_bias_walk == 2e-5);
  CHECK(model.acc_bias_walk == 1e-4);
  CHECK(model.initial_gyro_bias == Approx(0.5 * kDegree));
  CHECK(model.initial_acc_bias == Approx(0.020 * kStandardGravity));
  CHECK(model.gyro_range == Approx(2000 * kDegree));
  CHECK(model.acc_range == Approx(3 * kStandardGravity));
  CHECK(model.scale_error + model.cross_axis + model.g_sensitivity + model.delay == 0);
}

TEST_CASE("the datasheet preset, the default, stays within the limits of a BMI088", "[imu]") {
  const ImuModel model = imu_model({});
  CHECK(model.delay == Approx(0.002));
  const Walk walk = test::standing();
  double scale = 0, cross = 0, g = 0, gyro_bias = 0, acc_bias = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    ImuSimulator imu(walk, 0, model, seed);
    const ImuCalibration& c = imu.calibration();
    for (const Mat3* m : {&c.gyro_sensitivity, &c.acc_sensitivity}) {
      const Mat3 error = *m - Mat3::Identity();
      scale = std::max(scale, error.diagonal().cwiseAbs().maxCoeff());
      cross = std::max(cross, (error - Mat3(error.diagonal().asDiagonal())).cwiseAbs().maxCoeff());
    }
    g = std::max(g, c.g_sensitivity.cwiseAbs().maxCoeff());
    const ImuSimulator::Output first = imu.next();
    gyro_bias = std::max(gyro_bias, first.gyro_bias.cwiseAbs().maxCoeff());
    acc_bias = std::max(acc_bias, first.acc_bias.cwiseAbs().maxCoeff());
  }
  // Within the limits, and of 900 or more draws one comes near them.
  const auto just_below = [](double value, double limit) {
    return value <= limit * (1 + 1e-9) && value > 0.97 * limit;
  };
  CHECK(just_below(scale, 0.01));
  CHECK(just_below(cross, 0.005));
  CHECK(just_below(g * kStandardGravity, 0.1 * kDegree));
  CHECK(just_below(gyro_bias, 0.5 * kDegree));
  CHECK(just_below(acc_bias, 0.020 * kStandardGravity));
}

TEST_CASE("given values of the IMU replace those of the preset, in SI units", "[imu]") {
  ImuParams params = preset(ImuPreset::perfect, 400);
  params.gyro_noise = 1e-3;
  params.acc_noise = 2e-3;
  params.gyro_bias = 2;
  params.acc_bias = 5;
  params.gyro_bias_walk = 3e-5;
  params.acc_bias_walk = 4e-4;
  params.scale_error = 3;
  params.cross_axis = 2;
  params.g_sensitivity = 0.2;
  params.delay = 5;
  params.gyro_range = 500;
  params.acc_range = 6;
  const ImuModel model = imu_model(params);
  CHECK(model.rate == 400);
  CHECK(model.gyro_noise == 1e-3);
  CHECK(model.acc_noise == 2e-3);
  CHECK(model.initial_gyro_bias == Approx(2 * kDegree));
  CHECK(model.initial_acc_bias == Approx(0.005 * kStandardGravity));
  CHECK(model.gyro_bias_walk == 3e-5);
  CHECK(model.acc_bias_walk == 4e-4);
  CHECK(model.scale_error == Approx(0.03));
  CHECK(model.cross_axis == Approx(0.02));
  CHECK(model.g_sensitivity == Approx(0.2 * kDegree / kStandardGravity));
  CHECK(model.delay == Approx(0.005));
  CHECK(model.gyro_range == Approx(500 * kDegree));
  CHECK(model.acc_range == Approx(6 * kStandardGravity));
  params = {};
  params.scale_error = 0;
  CHECK(imu_model(params).scale_error == 0);
  CHECK(imu_model(params).cross_axis == Approx(0.005));
}
