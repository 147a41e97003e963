#pragma once
/// First-order transition of one IMU interval in block form, shared by the IMU motion models: only the blocks that are
/// neither zero nor identity are stored, so that propagating P costs a few 3x28 products.

#include "aslio/core/imu_mean.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// Error order (theta, p, v, b_w, b_a, g, s, d); noise order (n_w, n_a, n_bw, n_ba). docs/equations.md MOT-2.
struct ImuTransition {
  explicit ImuTransition(const ImuMean& input)
      : dt(input.dt), w_measured(input.w_measured), w_change(input.w_change), a_change(input.a_change) {}

  double dt = 0;
  double position_factor = 0;  ///< the p rows are this times the v rows, plus I and I dt: dt/2 (midpoint) or 0 (Euler)
  Mat3 theta_theta;            ///< Exp(-w dt)
  Mat3 theta_bw;               ///< -J_r(w dt) dt; also theta_nw
  Mat3 v_theta;
  Mat3 v_bw;  ///< also v_nw
  Mat3 v_ba;  ///< -R_m dt; also v_na
  // S_w acts as a gyro bias S_w w_measured, the delay d as biases -d w_change and -d a_change.
  Vec3 w_measured, w_change, a_change;

  void apply(const ImuNoise& noise, StateMatrix& P) const;
  void dense(StateMatrix& F, Eigen::Matrix<double, kStateDim, 12>& G) const;
};

}  // namespace aslio::plugins
