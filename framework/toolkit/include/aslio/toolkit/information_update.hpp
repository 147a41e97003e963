#pragma once
/// The update of an error-state Kalman filter in information form, without any inverse of the state's size: points see
/// the error state through a few combinations C x of it, of which the pose (theta, p) comes first (docs/equations.md
/// IESKF-1 .. IESKF-7; AS-LIO (11)-(13) corrected).

#include <Eigen/Geometry>
#include <optional>

#include "aslio/stages/history.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio {

/// Normal equations of point residuals for the pose error (theta, p): A = sum h^T h / R, b = sum h^T z / R.
struct PoseInformation {
  Mat6 A = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  double squared_sum = 0;   ///< of accepted residuals [m^2], unweighted
  double weighted_sum = 0;  ///< sum z^2 / R
  std::size_t accepted = 0;

  /// One row z = h(x): h = [(p_I x R^T u)^T, u^T], information 1/R.
  void add(const Vec3& p_I, const Mat3& R_transposed, const Vec3& u, double z, double information) {
    Vec6 h;
    const Vec3 u_I = R_transposed * u;
    h << p_I.cross(u_I), u;
    const Vec6 weighted = information * h;
    for (int column = 0; column < 6; ++column) A.col(column).noalias() += h[column] * weighted;  // in whole vectors
    b += z * weighted;
    squared_sum += z * z;
    weighted_sum += z * z * information;
    ++accepted;
  }
  PoseInformation& operator+=(const PoseInformation& other) {
    A += other.A;
    b += other.b;
    squared_sum += other.squared_sum;
    weighted_sum += other.weighted_sum;
    accepted += other.accepted;
    return *this;
  }
};

/// The same over a window whose points were measured tau [s] before its end: moments of tau show how errors that grow
/// with it (velocity, turn rate) show. eq. DSK-3.
struct WindowInformation : PoseInformation {
  Mat6 A1 = Mat6::Zero(), A2 = Mat6::Zero();  ///< sums of tau h^T h / R and tau^2 h^T h / R, both triangles
  Vec6 b1 = Vec6::Zero();                     ///< sum of tau h^T z / R

  void add_late(const Vec3& p_I, const Mat3& R_transposed, const Vec3& u, double z, double information, double tau) {
    Vec6 h;
    const Vec3 u_I = R_transposed * u;
    h << p_I.cross(u_I), u;
    const Vec6 weighted = information * h, later = tau * weighted;
    const Mat6 late = later * h.transpose();
    A.noalias() += weighted * h.transpose();
    A1 += late;
    A2 += tau * late;
    b += z * weighted;
    b1 += z * later;
    squared_sum += z * z;
    weighted_sum += z * z * information;
    ++accepted;
  }
  WindowInformation& operator+=(const WindowInformation& other) {
    PoseInformation::operator+=(other);
    A1 += other.A1;
    A2 += other.A2;
    b1 += other.b1;
    return *this;
  }
};

/// What the points of a window see: the errors (theta, p) of the pose at its end, and the errors (rate, velocity) with
/// which they were brought there.
inline constexpr int kSeenDim = 12;
/// Size of the state with what sensor_states.hpp adds.
inline constexpr int kWithSensors = kStateDim + 9;
using SeenRows = Eigen::Matrix<double, kSeenDim, kStateDim>;
using SeenMatrix = Eigen::Matrix<double, kSeenDim, kSeenDim>;
using SeenVector = Eigen::Matrix<double, kSeenDim, 1>;

/// x [-] x_hat for the error state (theta, p, v, b_w, b_a, g, s, d). eq. IESKF-2.
StateVector box_minus(const NavState& x, const NavState& reference);
/// x [+] delta. eq. IESKF-2. With `unit_gravity` the length of g is kept (S^2 up to second order).
NavState box_plus(const NavState& x, const StateVector& delta, bool unit_gravity);

/// The covariance after a step that turned g `from` there `to` here and kept its length: errors of g, whose block is at
/// `at`, turn with it. So they stay across it; otherwise a step along g, which is then taken back, leaves its share in
/// the states that go with it, update after update. eq. IESKF-14.
template <typename Matrix>
void turn_with_gravity(const Vec3& from, const Vec3& to, int at, Matrix& P) {
  const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
  P.template middleRows<3>(at) = (turn * P.template middleRows<3>(at)).eval();
  P.template middleCols<3>(at) = (P.template middleCols<3>(at) * turn.transpose()).eval();
}

/// Covariance of the prior seen from the current iterate: J^-1 P J^-T with J^-1 = blkdiag(J_r(d_theta), I). eq.
/// IESKF-3.
/// The first three components are theta, whatever the size S.
template <int S = kStateDim>
Eigen::Matrix<double, S, S> transported_covariance(const Eigen::Matrix<double, S, S>& P, const Vec3& d_theta);

/// delta = -P C^T S b - d + P C^T S A C d, S = (I + A C P C^T)^-1. eqs. IESKF-4, IESKF-5. `P` is the transported
/// covariance.
template <int N, int S = kStateDim>
Eigen::Matrix<double, S, 1> iteration_step(const Eigen::Matrix<double, S, S>& P, const Eigen::Matrix<double, N, S>& C,
                                           const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                                           const Eigen::Matrix<double, S, 1>& d);

/// z^T (H P H^T + R)^-1 z = sum z^2/R - b^T C P C^T S b, the squared innovation (NIS) of the residuals z, whose sum
/// z^2/R is `weighted_sum`. `P` is the covariance of the state at which they were taken. eq. IESKF-10.
template <int N, int S = kStateDim>
double squared_innovation(const Eigen::Matrix<double, S, S>& P, const Eigen::Matrix<double, N, S>& C,
                          const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                          double weighted_sum);

/// Posterior covariance when `A_new` comes from fresh and `A_all` from fresh and re-used residuals. A variance that
/// rounding leaves below 0, by 1e-12 at most, is 0. eqs. IESKF-6, HIS-3.
template <int N, int S = kStateDim>
Eigen::Matrix<double, S, S> posterior_covariance(const Eigen::Matrix<double, S, S>& P,
                                                 const Eigen::Matrix<double, N, S>& C,
                                                 const Eigen::Matrix<double, N, N>& A_new,
                                                 const Eigen::Matrix<double, N, N>& A_all, HistoryCovariance rule);

}  // namespace aslio
