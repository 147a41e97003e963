#pragma once
/// Rotation and delay between two things that measure the turns of one body.

#include <span>
#include <string>

#include "aslio/evaluation/turns.hpp"

namespace aslio::evaluation {

struct RotationFitOptions {
  Mat3 expected = Mat3::Identity();  ///< R_A_B by the files: what the data leave open is as they say
  double max_delay = 0.6;            ///< [s] looked for, either way
  bool gyro = true;                  ///< B is a gyro: with bias, errors of scale and axes, and perhaps a wrong sign
  double min_rate = 0.02;            ///< [rad/s] RMS about the axis that turns most: less is no motion
};

/// p_A = R_A_B p_B; what A shows at its stamp t, B shows at its stamp t + delay.
struct RotationFit {
  std::string problem;  ///< why there is none; empty: there is one
  bool unlike = false;  ///< that is no want of data: what is there does not measure one body's turns in rad
  std::size_t turns = 0;
  Mat3 R_A_B = Mat3::Identity();
  Mat3 covariance = Mat3::Zero();     ///< of the rotation, about the axes of A [rad^2]
  double delay = 0, sigma_delay = 0;  ///< [s]
  Vec3 signs = Vec3::Ones();          ///< of the axes of B: -1 where it measures the other way round
  Vec3 rate = Vec3::Zero();           ///< RMS about the axes of B, without its errors [rad/s]
  Vec3 bias = Vec3::Zero();           ///< of a gyro [rad/s]
  Mat3 sensitivity = Mat3::Zero();    ///< S of a gyro that measures (I + S) w and the bias; symmetric
  double ratio = 1;                   ///< of the lengths of the turns, B over A
  double correlation = 0;             ///< of these lengths at the delay
  double rms = 0;                     ///< of the turns that fit [rad]
};

/// The rotation that takes the turns of B to those of A (Wahba's problem, also with one axis reversed), then least
/// squares with delay, bias and errors of scale. Turns that do not fit weigh little. Standard deviations are of the
/// scatter between stretches of two seconds, so that errors that last may do so. eq. FRM-2, FRM-3
RotationFit fit_rotation(std::span<const MotionStretch> a, const TurnSource& b, const RotationFitOptions& options = {});

}  // namespace aslio::evaluation
