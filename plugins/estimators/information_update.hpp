#pragma once
/// The update of an error-state Kalman filter in information form, without any inverse of the state's size: all LiDAR
/// information lives in the top-left 6 x 6 block of the error state (docs/equations.md IESKF-1 .. IESKF-7; AS-LIO
/// (11)-(13) corrected).

#include <Eigen/Geometry>
#include <optional>

#include "aslio/stages/history.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// Normal equations of point residuals for the pose error (theta, p): A = sum h^T h / R, b = sum h^T z / R.
struct PoseInformation {
  Mat6 A = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  double squared_sum = 0;  ///< of accepted residuals [m^2], unweighted
  std::size_t accepted = 0;

  /// One row z = h(x): h = [(p_I x R^T u)^T, u^T], information 1/R. Only the lower triangle of A is touched.
  void add(const Vec3& p_I, const Mat3& R_transposed, const Vec3& u, double z, double information) {
    Vec6 h;
    const Vec3 u_I = R_transposed * u;
    h << p_I.cross(u_I), u;
    const Vec6 weighted = information * h;
    A.selfadjointView<Eigen::Lower>().rankUpdate(h, information);
    b += z * weighted;
    squared_sum += z * z;
    ++accepted;
  }
  PoseInformation& operator+=(const PoseInformation& other) {
    A += other.A;
    b += other.b;
    squared_sum += other.squared_sum;
    accepted += other.accepted;
    return *this;
  }
  /// A with both triangles.
  Mat6 full() const { return A.selfadjointView<Eigen::Lower>(); }
};

/// x [-] x_hat for the error state (theta, p, v, b_w, b_a, g, s, d).
StateVector box_minus(const NavState& x, const NavState& reference);
/// x [+] delta. With `unit_gravity` the length of g is kept (S^2 up to second order).
NavState box_plus(const NavState& x, const StateVector& delta, bool unit_gravity);

/// Covariance of the prior seen from the current iterate: J^-1 P J^-T with J^-1 = blkdiag(J_r(d_theta), I). eq.
/// IESKF-3.
StateMatrix transported_covariance(const StateMatrix& P, const Vec3& d_theta);

/// delta = -P_c S b - d + P_c S A d_{0:6}, S = (I + A P11)^-1. eq. IESKF-5. `P` is the transported covariance.
StateVector iteration_step(const StateMatrix& P, const Mat6& A, const Vec6& b, const StateVector& d);

/// Posterior covariance when `A_new` comes from fresh and `A_all` from fresh and re-used residuals. eqs. IESKF-6,
/// HIS-3.
StateMatrix posterior_covariance(const StateMatrix& P, const Mat6& A_new, const Mat6& A_all, HistoryCovariance rule);

}  // namespace aslio::plugins
