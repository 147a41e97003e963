#include "aslio/toolkit/initial_covariance.hpp"

#include <algorithm>

#include "aslio/core/angles.hpp"

namespace aslio {

namespace {

double squared(double x) { return x * x; }

}  // namespace

void describe_gravity(config::Binder& b, EstimatedStates::Gravity& gravity) {
  using Gravity = EstimatedStates::Gravity;
  b.choice("gravity", gravity, {{"s2", Gravity::s2}, {"free", Gravity::free}, {"fixed", Gravity::fixed}},
           "what of gravity is estimated: its direction, all three components, or nothing");
}

void describe_estimated(config::Binder& b, EstimatedStates& p) {
  using GyroCalibration = EstimatedStates::GyroCalibration;
  describe_gravity(b, p.gravity);
  b.real("sigma_gravity", p.sigma_gravity, "m/s^2", {.above = 0, .max = 10},
         "gravity: free alone: standard deviation of the length of g at the start (latitude and height change g by "
         "0.03 m/s^2)");
  b.real("gravity_walk", p.gravity_walk, "deg/sqrt(s)", {.min = 0, .max = 10},
         "gravity: s2, free: random walk of the direction of gravity in the map, by which a map bends as it grows "
         "(0: none)");
  b.choice("gyro_calibration", p.gyro_calibration,
           {{"none", GyroCalibration::none}, {"diagonal", GyroCalibration::diagonal}, {"full", GyroCalibration::full}},
           "what of the gyro's sensitivity is estimated: nothing, its scale factors, or cross-axis terms, too");
  b.real("sigma_gyro_scale", p.sigma_gyro_scale, "", {.above = 0, .max = 0.5},
         "gyro_calibration: diagonal, full: standard deviation of each scale factor at the start (0.01: an "
         "uncalibrated MEMS gyro; of a calibrated one: that of its calibration)");
  b.real("sigma_gyro_cross", p.sigma_gyro_cross, "", {.above = 0, .max = 0.5},
         "gyro_calibration: full: standard deviation of each cross-axis term at the start");
  b.reals("sigma_gyro_sensitivity", p.sigma_gyro_sensitivity, 0, "", {.above = 0, .max = 0.5},
          "gyro_calibration: diagonal, full: standard deviation of each of the nine entries of the gyro's sensitivity "
          "at the start, row by row. It replaces the two above; `aslio calibrate` gives it (empty: the two above)");
  b.require(p.sigma_gyro_sensitivity.empty() || p.sigma_gyro_sensitivity.size() == 9, "sigma_gyro_sensitivity",
            "must be empty or nine numbers, row by row");
  b.flag("time_offset", p.time_offset, "estimate the delay of the IMU");
  b.real("sigma_time_offset", p.sigma_time_offset, "s", {.above = 0, .max = 1},
         "time_offset: standard deviation of the delay at the start");
}

// eq. INI-4.
StateMatrix initial_covariance(const InitialState& initial, const EstimatedStates& estimated, double sigma_velocity) {
  StateMatrix P = StateMatrix::Zero();
  // The world is defined by the first pose, so pose errors start at zero and the error of the measured vertical is one
  // of g.
  P.diagonal().segment<3>(block::theta).setConstant(1e-8);
  P.diagonal().segment<3>(block::p).setConstant(1e-8);
  P.diagonal().segment<3>(block::v).setConstant(squared(sigma_velocity));
  P.diagonal().segment<3>(block::b_w).setConstant(squared(initial.sigma_gyro_bias));
  P.diagonal().segment<3>(block::b_a).setConstant(squared(initial.sigma_acc_bias));
  if (estimated.gravity != EstimatedStates::Gravity::fixed) {
    const double g = initial.state.g.norm();
    const Vec3 up = initial.state.g / g;
    Mat3 spread = squared(initial.sigma_tilt) * g * g * (Mat3::Identity() - up * up.transpose());
    if (estimated.gravity == EstimatedStates::Gravity::free) {
      spread += squared(estimated.sigma_gravity) * up * up.transpose();
    }
    P.block<3, 3>(block::g, block::g) = spread;
  }
  using Calibration = EstimatedStates::GyroCalibration;
  const Calibration calibrated = estimated.gyro_calibration;
  const auto& each = estimated.sigma_gyro_sensitivity;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const bool scale = row == column;
      if (calibrated == Calibration::none || (calibrated == Calibration::diagonal && !scale)) continue;
      const double usual = scale ? estimated.sigma_gyro_scale : estimated.sigma_gyro_cross;
      const int k = block::s + 3 * column + row;
      P(k, k) = squared(each.empty() ? usual : each[static_cast<std::size_t>(3 * row + column)]);
    }
  }
  if (estimated.time_offset) P(block::d, block::d) = squared(estimated.sigma_time_offset);
  return P;
}

// eq. MOT-8.
void walk_gravity(const EstimatedStates& estimated, const Vec3& g, double dt, StateMatrix& P) {
  if (estimated.gravity_walk <= 0 || estimated.gravity == EstimatedStates::Gravity::fixed) return;
  const double walk = estimated.gravity_walk * kRadPerDeg;
  P.block<3, 3>(block::g, block::g) += walk * walk * dt * (g.squaredNorm() * Mat3::Identity() - g * g.transpose());
}

// eq. MOT-12.
bool hold_calibration(std::span<const ImuSample> imu, StateMatrix& P) {
  constexpr auto unread = imu_fault::gyro_dead | imu_fault::gyro_clipped;
  if (std::none_of(imu.begin(), imu.end(), [](const ImuSample& s) { return (s.faults & unread) != 0; })) return false;
  constexpr int sensor[][2] = {{block::b_w, 3}, {block::b_a, 3}, {block::s, 9}, {block::d, 1}};
  constexpr int motion[] = {block::theta, block::p, block::v, block::g};
  for (const auto& [of, size] : sensor) {
    for (const int at : motion) {
      P.block(of, at, size, 3).setZero();
      P.block(at, of, 3, size).setZero();
    }
  }
  return true;
}

}  // namespace aslio
