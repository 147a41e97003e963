/// What an IMU does beyond white noise.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/simulator/imu_model.hpp"
#include "simulator/imu/motions.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::test;

namespace {

ImuModel exact() {
  ImuModel model;
  model.gyro_noise = model.acc_noise = model.gyro_bias_walk = model.acc_bias_walk = 0;
  model.initial_gyro_bias = model.initial_acc_bias = 0;
  model.gyro_range = model.acc_range = 1e9;
  return model;
}

/// Turns to and fro about z.
class Oscillation final : public Motion {
 public:
  explicit Oscillation(double frequency) : w_(2 * std::numbers::pi * frequency) {}
  MotionState at(double t) const override {
    MotionState state;
    state.w.z() = std::sin(w_ * t);
    return state;
  }
  double duration() const override { return 10; }

 private:
  double w_;
};

double amplitude(double frequency, double filter) {
  ImuModel model = exact();
  model.rate = 1000;
  model.filter = filter;
  double most = 0;
  for (const ImuSample& sample : simulate_imu(Oscillation(frequency), 0, 10, model, 1).samples)
    most = std::max(most, std::abs(sample.gyro.z()));
  return most;
}

}  // namespace

TEST_CASE("a filter damps as the mean over its time does", "[realism]") {
  for (const double frequency : {3.0, 51.0, 103.0}) {
    const double x = std::numbers::pi * frequency * 0.005;
    CHECK(amplitude(frequency, 0.005) == Approx(std::sin(x) / x).epsilon(0.01));
    CHECK(amplitude(frequency, 0) == Approx(1).epsilon(0.01));
  }
}

TEST_CASE("a warming IMU drifts, and the true biases drift with it", "[realism]") {
  ImuModel model = exact();
  model.warming = 10;
  const ImuRecord record = simulate_imu(standing(), 0, 900, model, 4);
  const Vec3 gyro = record.gyro_bias.back(), acc = record.acc_bias.back();
  CHECK(gyro.norm() > 0);
  CHECK(gyro.cwiseAbs().maxCoeff() <= 10 * 0.015 * kRadPerDeg);
  CHECK(acc.cwiseAbs().maxCoeff() <= 10 * 0.2e-3 * kStandardGravity);
  const auto at_300 = static_cast<std::size_t>(300 * model.rate);
  CHECK(record.gyro_bias[at_300].x() / gyro.x() == Approx((1 - std::exp(-1.0)) / (1 - std::exp(-3.0))));
  CHECK((record.samples.back().gyro - gyro).norm() < 1e-12);
  CHECK((record.samples.back().acc - acc - Vec3(0, 0, kStandardGravity)).norm() < 1e-12);
}

TEST_CASE("the LiDAR's motor shakes the accelerometer alone", "[realism]") {
  ImuModel model = exact();
  model.vibration = 0.3;
  model.motor = 121.6;
  const ImuRecord record = simulate_imu(standing(), 0, 20, model, 4);
  double squares = 0;
  for (const ImuSample& sample : record.samples) {
    squares += (sample.acc - Vec3(0, 0, kStandardGravity)).squaredNorm();
    REQUIRE(sample.gyro.norm() == 0);
  }
  CHECK(std::sqrt(squares / static_cast<double>(record.samples.size())) == Approx(0.3 * std::sqrt(1.5)).epsilon(0.02));
}
