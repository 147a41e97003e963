#include <Eigen/Dense>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/imu_params.hpp"
#include "motions.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// Allan variance at averaging times of 2^k samples (clusters side by side), in constant memory: pairs of clusters of
/// one length are averaged into clusters of the double length.
class AllanVariance {
 public:
  static constexpr std::size_t kOctaves = 17;

  void add(double sample) {
    double average = sample;
    for (std::size_t k = 0; k < kOctaves; ++k) {
      Octave& octave = octaves_[k];
      if (octave.clusters++ > 0) octave.squares += (average - octave.last) * (average - octave.last);
      const double before = octave.last;
      octave.last = average;
      if (octave.clusters % 2 != 0) return;
      average = 0.5 * (before + average);
    }
  }
  double at(std::size_t k) const { return octaves_[k].squares / (2 * static_cast<double>(octaves_[k].clusters - 1)); }

 private:
  struct Octave {
    double last = 0, squares = 0;
    std::int64_t clusters = 0;
  };
  std::array<Octave, kOctaves> octaves_;
};

struct Densities {
  double white = 0, walk = 0;
};

/// variance = white^2 / tau + walk^2 tau / 3, least squares of the relative residuals weighted by the number of
/// clusters.
Densities fitted(const AllanVariance& variance, double rate) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < AllanVariance::kOctaves; ++k) {
    const double tau = std::exp2(static_cast<double>(k)) / rate;
    const Eigen::Vector2d row = Eigen::Vector2d(1 / tau, tau / 3) / variance.at(k);
    normal += row * row.transpose() / tau;
    right += row / tau;
  }
  const Eigen::Vector2d squares = normal.inverse() * right;
  return {std::sqrt(squares[0]), std::sqrt(squares[1])};
}

}  // namespace

TEST_CASE("the Allan variance of a motionless IMU has the configured noise densities and bias walks", "[imu]") {
  // White noise is seen in millions of clusters. The walk prevails beyond sqrt(3) white / walk: 21 s for the gyro, 30 s
  // for the accelerometer. 100 000 s hold 1220 clusters of 82 s and 2441 of 41 s; a deviation from n clusters is good
  // to 1 / sqrt(2 n), so these alone give each axis' walk to 2 %, and 10 % is five times that.
  constexpr double kDuration = 100'000;
  ImuParams ideal;
  ideal.preset = ImuPreset::ideal;
  const ImuModel model = imu_model(ideal);
  const Walk walk = test::standing();
  ImuSimulator imu(walk, 0, model, 1);
  std::array<AllanVariance, 3> gyro, acc;
  const auto count = static_cast<std::int64_t>(kDuration * model.rate);
  for (std::int64_t sample = 0; sample < count; ++sample) {
    const ImuSample s = imu.next().sample;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gyro[axis].add(s.gyro[static_cast<int>(axis)]);
      acc[axis].add(s.acc[static_cast<int>(axis)]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    INFO("axis " << axis);
    const Densities of_gyro = fitted(gyro[axis], model.rate), of_acc = fitted(acc[axis], model.rate);
    CHECK(of_gyro.white == Approx(model.gyro_noise).epsilon(0.01));
    CHECK(of_acc.white == Approx(model.acc_noise).epsilon(0.01));
    CHECK(of_gyro.walk == Approx(model.gyro_bias_walk).epsilon(0.1));
    CHECK(of_acc.walk == Approx(model.acc_bias_walk).epsilon(0.1));
  }
}
