#include "aslio/toolkit/information_update.hpp"

#include <Eigen/LU>

namespace aslio {

namespace {

/// P C^T S with S = (I + A C P C^T)^-1: the gain of the information. A may be singular. eq. IESKF-4.
template <int N, int S>
Eigen::Matrix<double, S, N> information_gain(const Eigen::Matrix<double, S, S>& P, const Eigen::Matrix<double, N, S>& C,
                                             const Eigen::Matrix<double, N, N>& A) {
  using Square = Eigen::Matrix<double, N, N>;
  const Eigen::Matrix<double, S, N> P_c = P * C.transpose();
  const Square S_inverse = Square::Identity() + A * (C * P_c);
  const Eigen::PartialPivLU<Square> lu(S_inverse);
  return P_c * lu.inverse();
}

/// What is known exactly has no variance, as the length of g where it points straight down. Rounding may put it below
/// 0.
template <class Square>
void clear_rounding(Square& P) {
  constexpr double rounding = 1e-12;  // squared units of the state; more below 0 is an error, for the caller to see
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    if (!(P(i, i) < 0 && P(i, i) > -rounding)) continue;
    P.row(i).setZero();
    P.col(i).setZero();
  }
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

template <int S>
Eigen::Matrix<double, S, S> transported_covariance(const Eigen::Matrix<double, S, S>& P, const Vec3& d_theta) {
  const Mat3 J = right_jacobian_so3(d_theta);
  Eigen::Matrix<double, S, S> out = P;
  out.template topRows<3>() = J * P.template topRows<3>();
  out.template leftCols<3>() = (out.template leftCols<3>() * J.transpose()).eval();
  return out;
}

template <int N, int S>
Eigen::Matrix<double, S, 1> iteration_step(const Eigen::Matrix<double, S, S>& P, const Eigen::Matrix<double, N, S>& C,
                                           const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                                           const Eigen::Matrix<double, S, 1>& d) {
  const Eigen::Matrix<double, N, 1> seen = C * d;
  return information_gain<N, S>(P, C, A) * (A * seen - b) - d;
}

template <int N, int S>
double squared_innovation(const Eigen::Matrix<double, S, S>& P, const Eigen::Matrix<double, N, S>& C,
                          const Eigen::Matrix<double, N, N>& A, const Eigen::Matrix<double, N, 1>& b,
                          double weighted_sum) {
  const Eigen::Matrix<double, N, 1> explained = C * (information_gain<N, S>(P, C, A) * b);
  return weighted_sum - b.dot(explained);
}

template <int N, int S>
Eigen::Matrix<double, S, S> posterior_covariance(const Eigen::Matrix<double, S, S>& P,
                                                 const Eigen::Matrix<double, N, S>& C,
                                                 const Eigen::Matrix<double, N, N>& A_new,
                                                 const Eigen::Matrix<double, N, N>& A_all, HistoryCovariance rule) {
  using Square = Eigen::Matrix<double, S, S>;
  Square out;
  if (rule == HistoryCovariance::joseph) {
    const Eigen::Matrix<double, S, N> gain = information_gain<N, S>(P, C, A_all), used = gain * A_new;
    Square X = Square::Identity();
    X.noalias() -= used * C;
    out.noalias() = X * P * X.transpose();
    out.noalias() += used * gain.transpose();
  } else {
    const Eigen::Matrix<double, N, N>& A = rule == HistoryCovariance::new_only ? A_new : A_all;
    out = P;
    const Eigen::Matrix<double, S, N> used = information_gain<N, S>(P, C, A) * A;
    out.noalias() -= used * (C * P);
  }
  out = (0.5 * (out + out.transpose())).eval();
  clear_rounding(out);
  return out;
}

// The pose alone; what a window sees; and that together with states of the sensors (sensor_states.hpp).
template <int N, int S>
struct Of {
  using P = Eigen::Matrix<double, S, S>;
  using C = Eigen::Matrix<double, N, S>;
  using A = Eigen::Matrix<double, N, N>;
  using b = Eigen::Matrix<double, N, 1>;
  using x = Eigen::Matrix<double, S, 1>;
};
#define ASLIO_INSTANTIATE(N, S)                                                                               \
  template Of<N, S>::x iteration_step<N, S>(const Of<N, S>::P&, const Of<N, S>::C&, const Of<N, S>::A&,       \
                                            const Of<N, S>::b&, const Of<N, S>::x&);                          \
  template double squared_innovation<N, S>(const Of<N, S>::P&, const Of<N, S>::C&, const Of<N, S>::A&,        \
                                           const Of<N, S>::b&, double);                                       \
  template Of<N, S>::P posterior_covariance<N, S>(const Of<N, S>::P&, const Of<N, S>::C&, const Of<N, S>::A&, \
                                                  const Of<N, S>::A&, HistoryCovariance)
ASLIO_INSTANTIATE(6, kStateDim);
ASLIO_INSTANTIATE(kSeenDim, kStateDim);
ASLIO_INSTANTIATE(kSeenDim, kWithSensors);
#undef ASLIO_INSTANTIATE
template StateMatrix transported_covariance<kStateDim>(const StateMatrix&, const Vec3&);
template Of<kSeenDim, kWithSensors>::P transported_covariance<kWithSensors>(const Of<kSeenDim, kWithSensors>::P&,
                                                                            const Vec3&);

}  // namespace aslio
