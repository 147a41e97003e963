#pragma once
/// One segment of a uniform cubic B-spline of pose: position additive, attitude cumulative on SO(3)
/// (docs/equations.md SPL-1 to SPL-3; Sommer et al., CVPR 2020).

#include <array>

#include "aslio/core/types.hpp"

namespace aslio::plugins {

/// Cumulative weights lambda_1 to lambda_3 at share u of a segment of `interval` seconds, with their derivatives by
/// time [1/s], [1/s^2]. lambda_0 is 1. eq. SPL-1.
struct CumulativeBasis {
  Vec3 value, first, second;

  CumulativeBasis(double u, double interval);
};

/// The four control poses of a segment. Number i belongs to i - 1 intervals after the begin of the segment: a motion of
/// constant velocity and rate has them on its path.
using ControlPoses = std::array<Pose, 4>;

/// The motion of one moment.
struct SplineMoment {
  Mat3 R = Mat3::Identity();  ///< R_W_I
  Vec3 p = Vec3::Zero();      ///< [m], in W
  Vec3 v = Vec3::Zero();      ///< [m/s], in W
  Vec3 a_W = Vec3::Zero();    ///< [m/s^2], in W
  Vec3 w = Vec3::Zero();      ///< [rad/s], in I
  Vec3 w_dot = Vec3::Zero();  ///< [rad/s^2], in I

  Pose pose() const { return {R, p}; }
};

/// Derivatives of a moment by errors (theta, p) of the control poses, R_i Exp(theta_i) and p_i + dp_i. eq. SPL-3.
struct SplineSlopes {
  std::array<Mat3, 4> theta;    ///< of the error of R (right), by theta_i
  std::array<Mat3, 4> w;        ///< of w, by theta_i
  std::array<double, 4> p{};    ///< of p, by p_i: so many times I
  std::array<double, 4> v{};    ///< of v, by p_i [1/s]
  std::array<double, 4> a_W{};  ///< of a_W, by p_i [1/s^2]
};

class CubicSplineSegment {
 public:
  /// `interval` between knots [s], > 0. Pre: attitudes of neighbours are less than pi apart.
  CubicSplineSegment(const ControlPoses& control, double interval);

  /// At share u in [0, 1] of the segment. eq. SPL-2.
  Pose pose(double u) const;
  SplineMoment at(double u) const;
  SplineSlopes slopes(double u) const;

 private:
  double interval_;
  ControlPoses control_;
  std::array<Vec3, 3> turn_;  ///< Log(R_{j-1}^T R_j)
};

}  // namespace aslio::plugins
