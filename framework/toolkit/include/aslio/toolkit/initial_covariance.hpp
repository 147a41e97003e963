#pragma once

#include <span>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/estimator.hpp"

namespace aslio {

/// What a filter estimates besides pose, velocity and biases.
struct EstimatedStates {
  enum class Gravity : std::uint8_t { s2, free, fixed };
  enum class GyroCalibration : std::uint8_t { none, diagonal, full };
  Gravity gravity = Gravity::s2;
  double sigma_gravity = 0.01;  ///< of the length of g where all of it is estimated [m/s^2]
  /// Of the direction of gravity in the map's frame, where it is estimated [deg/sqrt(s)] (docs/equations.md MOT-8).
  double gravity_walk = 0;
  GyroCalibration gyro_calibration = GyroCalibration::none;
  bool time_offset = false;
  // Standard deviations at the start of what is estimated of the IMU: data-sheet limits of MEMS gyros such as the
  // BMI088.
  double sigma_gyro_scale = 0.01;              ///< of each scale factor
  double sigma_gyro_cross = 0.005;             ///< of each cross-axis term
  std::vector<double> sigma_gyro_sensitivity;  ///< of each entry of S, row by row, in place of those two; empty: those
  double sigma_time_offset = 0.003;            ///< [s]
};

void describe_gravity(config::Binder& b, EstimatedStates::Gravity& gravity);
void describe_estimated(config::Binder& b, EstimatedStates& p);

/// Covariance at the start (docs/equations.md INI-4): zero for what is not estimated. `sigma_velocity` [m/s] stands in
/// place of the initial state's.
StateMatrix initial_covariance(const InitialState& initial, const EstimatedStates& estimated, double sigma_velocity);

/// Adds to P what gravity `g` [m/s^2] may have turned against the map in `dt` [s] (eq. MOT-8).
void walk_gravity(const EstimatedStates& estimated, const Vec3& g, double dt, StateMatrix& P);

/// Where the gyro was dead or at the end of its range, sets the covariances between motion (pose, velocity, gravity)
/// and calibration (biases, scale, delay) to 0: what is no reading says nothing of the sensor that did not read it
/// (docs/equations.md MOT-12). Returns whether it did.
bool hold_calibration(std::span<const ImuSample> imu, StateMatrix& P);

}  // namespace aslio
