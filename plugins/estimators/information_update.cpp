#include "estimators/information_update.hpp"

#include <Eigen/LU>

namespace aslio::plugins {

namespace {

/// P C^T S with S = (I + A C P C^T)^-1: the gain of the information. A may be singular. eq. IESKF-4.
template <int N>
Eigen::Matrix<double, kStateDim, N> information_gain(const StateMatrix& P, const Eigen::Matrix<double, N, kStateDim>& C,
                                                     const Eigen::Matrix<double, N, N>& A) {
  using Square = Eigen::Matrix<double, N, N>;
  const Eigen::Matrix<double, kStateDim, N> P_c = P * C.transpose();
  const Square S_inverse = Square::Identity() + A * (C * P_c);
  const Eigen::PartialPivLU<Square> lu(S_inverse);
  return P_c * lu.inverse();
}

}  // namespace

// eq. IESKF-2.
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

template <int N>
StateVector iteration_step(const StateMatrix& P, const Eigen::Matrix<double, N, kStateDim>& C,
                           const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                           const StateVector& d) {
  const Eigen::Matrix<double, N, 1> seen = C * d;
  return information_gain<N>(P, C, A) * (A * seen - b) - d;
}

template <int N>
double squared_innovation(const StateMatrix& P, const Eigen::Matrix<double, N, kStateDim>& C,
                          const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                          double weighted_sum) {
  const Eigen::Matrix<double, N, 1> explained = C * (information_gain<N>(P, C, A) * b);
  return weighted_sum - b.dot(explained);
}

template <int N>
StateMatrix posterior_covariance(const StateMatrix& P, const Eigen::Matrix<double, N, kStateDim>& C,
                                 const Eigen::Matrix<double, N, N>& A_new, const Eigen::Matrix<double, N, N>& A_all,
                                 HistoryCovariance rule) {
  StateMatrix out;
  if (rule == HistoryCovariance::joseph) {
    const Eigen::Matrix<double, kStateDim, N> gain = information_gain<N>(P, C, A_all), used = gain * A_new;
    StateMatrix X = StateMatrix::Identity();
    X.noalias() -= used * C;
    out.noalias() = X * P * X.transpose();
    out.noalias() += used * gain.transpose();
  } else {
    const Eigen::Matrix<double, N, N>& A = rule == HistoryCovariance::new_only ? A_new : A_all;
    out = P;
    const Eigen::Matrix<double, kStateDim, N> used = information_gain<N>(P, C, A) * A;
    out.noalias() -= used * (C * P);
  }
  return 0.5 * (out + out.transpose());
}

template StateVector iteration_step<6>(const StateMatrix&, const Eigen::Matrix<double, 6, kStateDim>&, const Mat6&,
                                       const Vec6&, const StateVector&);
template StateVector iteration_step<kSeenDim>(const StateMatrix&, const SeenRows&,
                                              const Eigen::Matrix<double, kSeenDim, kSeenDim>&,
                                              const Eigen::Matrix<double, kSeenDim, 1>&, const StateVector&);
template double squared_innovation<6>(const StateMatrix&, const Eigen::Matrix<double, 6, kStateDim>&, const Mat6&,
                                      const Vec6&, double);
template double squared_innovation<kSeenDim>(const StateMatrix&, const SeenRows&,
                                             const Eigen::Matrix<double, kSeenDim, kSeenDim>&,
                                             const Eigen::Matrix<double, kSeenDim, 1>&, double);
template StateMatrix posterior_covariance<6>(const StateMatrix&, const Eigen::Matrix<double, 6, kStateDim>&,
                                             const Mat6&, const Mat6&, HistoryCovariance);
template StateMatrix posterior_covariance<kSeenDim>(const StateMatrix&, const SeenRows&,
                                                    const Eigen::Matrix<double, kSeenDim, kSeenDim>&,
                                                    const Eigen::Matrix<double, kSeenDim, kSeenDim>&,
                                                    HistoryCovariance);

}  // namespace aslio::plugins
