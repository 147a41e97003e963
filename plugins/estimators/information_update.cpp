#include "estimators/information_update.hpp"

#include <Eigen/LU>

namespace aslio::plugins {

namespace {

using Columns = Eigen::Matrix<double, kStateDim, 6>;

/// P_c S with P_c = P(:, 0:6) and S = (I + A P11)^-1: the gain of the pose information. A may be singular.
Columns information_gain(const StateMatrix& P, const Mat6& A) {
  const Mat6 S_inverse = Mat6::Identity() + A * P.topLeftCorner<6, 6>();
  const Eigen::PartialPivLU<Mat6> lu(S_inverse);
  return P.leftCols<6>() * lu.inverse();
}

}  // namespace

StateVector box_minus(const NavState& x, const NavState& reference) {
  StateVector d;
  d << log_so3(reference.R.transpose() * x.R), x.p - reference.p, x.v - reference.v, x.b_w - reference.b_w,
      x.b_a - reference.b_a, x.g - reference.g, (x.S_w - reference.S_w).reshaped(), x.imu_delay - reference.imu_delay;
  return d;
}

NavState box_plus(const NavState& x, const StateVector& delta, bool unit_gravity) {
  NavState y = x;
  y.R = orthonormalised(x.R * exp_so3(delta.segment<3>(block::theta)));
  y.p += delta.segment<3>(block::p);
  y.v += delta.segment<3>(block::v);
  y.b_w += delta.segment<3>(block::b_w);
  y.b_a += delta.segment<3>(block::b_a);
  y.g += delta.segment<3>(block::g);
  y.S_w += delta.segment<9>(block::s).reshaped(3, 3);
  y.imu_delay += delta[block::d];
  if (unit_gravity) y.g *= x.g.norm() / y.g.norm();
  return y;
}

StateMatrix transported_covariance(const StateMatrix& P, const Vec3& d_theta) {
  const Mat3 J = right_jacobian_so3(d_theta);
  StateMatrix out = P;
  out.topRows<3>() = J * P.topRows<3>();
  out.leftCols<3>() = (out.leftCols<3>() * J.transpose()).eval();
  return out;
}

StateVector iteration_step(const StateMatrix& P, const Mat6& A, const Vec6& b, const StateVector& d) {
  const Columns gain = information_gain(P, A);
  return gain * (A * d.head<6>() - b) - d;
}

StateMatrix posterior_covariance(const StateMatrix& P, const Mat6& A_new, const Mat6& A_all, HistoryCovariance rule) {
  StateMatrix out;
  if (rule == HistoryCovariance::joseph) {
    const Columns gain = information_gain(P, A_all);
    StateMatrix X = StateMatrix::Identity();
    X.leftCols<6>().noalias() -= gain * A_new;
    out.noalias() = X * P * X.transpose();
    out.noalias() += gain * A_new * gain.transpose();
  } else {
    const Mat6& A = rule == HistoryCovariance::new_only ? A_new : A_all;
    out = P;
    out.noalias() -= information_gain(P, A) * A * P.leftCols<6>().transpose();
  }
  return 0.5 * (out + out.transpose());
}

}  // namespace aslio::plugins
