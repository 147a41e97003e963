#pragma once
/// Where a point whose positions are known (a GNSS antenna, a prism) sits on a body that measures poses.

#include <span>
#include <string>

#include "aslio/evaluation/turns.hpp"

namespace aslio::evaluation {

struct PointFitOptions {
  Vec3 expected = Vec3::Zero();  ///< [m] of the point in the frame of A by the files: what the data leave open
  double delay = 0;              ///< [s] where the search begins
  double max_gap = 0.25;         ///< [s] of the positions to interpolate across
  double piece = 10.0;           ///< [s] over which the poses of A hardly drift
};

/// What A shows at its stamp t, the positions show at their stamp t + delay.
struct PointFit {
  std::string problem;  ///< why there is none; empty: there is one
  std::size_t pieces = 0;
  Vec3 point = Vec3::Zero();          ///< in the frame of A [m]
  Mat3 covariance = Mat3::Zero();     ///< of it [m^2]
  double delay = 0, sigma_delay = 0;  ///< [s]
  double rms = 0;                     ///< of the positions [m]
};

/// Least squares over pieces, each of which has a world of its own; point and delay are common to all. Of `positions`
/// the orientations are not used. eq. FRM-7
PointFit fit_point(std::span<const MotionStretch> a, const Trajectory& positions, const PointFitOptions& options);

}  // namespace aslio::evaluation
