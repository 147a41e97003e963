#pragma once
/// Attitude and displacement by the IMU alone over a short time.

#include <span>
#include <vector>

#include "sweep_cells.hpp"

namespace aslio::pipeline {

/// Readings as they are: a bias has to be taken off before.
class InertialPath {
 public:
  /// Begins at `begin`, which the first of `imu` has; without samples nothing moves.
  InertialPath(std::span<const ImuSample> imu, TimeNs begin);
  /// Where a point p_I [m] is seen from at `t`, which does not decrease from call to call.
  SweepPoint point(const Vec3& p_I, TimeNs t);

 private:
  struct Knot {
    TimeNs t;
    Mat3 R;     ///< R_B_I
    Vec3 v, s;  ///< by specific force alone [m/s], [m]
  };
  std::vector<Knot> knots_;
  std::size_t at_ = 0;
};

}  // namespace aslio::pipeline
