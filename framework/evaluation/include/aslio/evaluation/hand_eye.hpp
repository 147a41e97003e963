#pragma once
/// Where one sensor sits on a body, seen from another one that also measures poses.

#include <span>
#include <string>

#include "aslio/evaluation/turns.hpp"

namespace aslio::evaluation {

struct HandEyeOptions {
  Pose expected;                  ///< T_B_A by the files: what the data leave open is as it says
  Mat3 start = Mat3::Identity();  ///< rotation of T_B_A where the search begins
  double delay = 0;               ///< [s] where the search begins
  double max_gap = 0.25;          ///< [s] of the poses of B to interpolate across
  double span = 1.0;              ///< [s] of a relative motion; half of them have three times as much
};

/// p_B = T_B_A p_A; what A shows at its stamp t, B shows at its stamp t + delay.
struct HandEye {
  std::string problem;  ///< why there is none; empty: there is one
  std::size_t pairs = 0;
  Pose T_B_A;
  Mat6 covariance = Mat6::Zero();     ///< of (theta, p), both in the axes of B [rad^2, m^2]
  double delay = 0, sigma_delay = 0;  ///< [s]
  double rms_expected = 0, rms = 0;   ///< of the displacements that fit, with the expected pose and with this one [m]
};

/// Solves A X = X B over relative motions of `span`, rotation, position and delay together, with weights that fall with
/// the residual. Where the body hardly turns the position along that axis is open: its deviation says so. eq. FRM-4
HandEye fit_hand_eye(std::span<const MotionStretch> a, const Trajectory& b, const HandEyeOptions& options);

}  // namespace aslio::evaluation
