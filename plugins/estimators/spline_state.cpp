#include "estimators/spline_state.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

namespace aslio::plugins {

namespace sp = spline;

namespace {

constexpr TimeNs kLongestChain = 10 * kSecond;  // over which control poses are added one by one

using MomentOfControl = Eigen::Matrix<double, sp::kMomentDim, sp::kDim>;

void symmetrise(sp::Matrix& P) { P = (0.5 * (P + P.transpose())).eval(); }

/// Derivative of a moment by the state.
MomentOfControl moment_slopes(const SplineState& x, TimeNs t) {
  const SplineSlopes slopes = x.segment().slopes(x.share(t));
  MomentOfControl M = MomentOfControl::Zero();
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    M.block<3, 3>(sp::moment::theta, sp::theta(i)) = slopes.theta[k];
    M.block<3, 3>(sp::moment::w, sp::theta(i)) = slopes.w[k];
    M.block<3, 3>(sp::moment::p, sp::p(i)).diagonal().setConstant(slopes.p[k]);
    M.block<3, 3>(sp::moment::v, sp::p(i)).diagonal().setConstant(slopes.v[k]);
  }
  M.bottomRightCorner<9, 9>().setIdentity();
  return M;
}

}  // namespace

double SplineState::share(TimeNs t) const { return std::clamp(to_seconds(t - begin) / to_seconds(interval), 0.0, 1.0); }

NavState SplineState::nav(TimeNs t) const {
  const SplineMoment at = moment(t);
  NavState out;
  out.t = t;
  out.R = orthonormalised(at.R);
  out.p = at.p;
  out.v = at.v;
  out.b_w = b_w;
  out.b_a = b_a;
  out.g = g;
  return out;
}

bool SplineState::finite() const {
  const auto finite_pose = [](const Pose& pose) { return pose.R.allFinite() && pose.p.allFinite(); };
  return std::all_of(control.begin(), control.end(), finite_pose) && b_w.allFinite() && b_a.allFinite() &&
         g.allFinite();
}

void SplineState::set(TimeNs t, const Pose& at, const Vec3& v, const Vec3& w) {
  begin = t;
  for (int i = 0; i < 4; ++i) {
    const double tau = after(i, t);
    control[static_cast<std::size_t>(i)] = {orthonormalised(at.R * exp_so3(tau * w)), at.p + tau * v};
  }
}

void SplineState::change_velocity(TimeNs t, const Vec3& by) {
  for (int i = 0; i < 4; ++i) control[static_cast<std::size_t>(i)].p += after(i, t) * by;
}

void SplineState::add(const sp::Vector& delta, bool unit_gravity) {
  for (int i = 0; i < 4; ++i) {
    Pose& pose = control[static_cast<std::size_t>(i)];
    pose.R = orthonormalised(pose.R * exp_so3(delta.segment<3>(sp::theta(i))));
    pose.p += delta.segment<3>(sp::p(i));
  }
  b_w += delta.segment<3>(sp::b_w);
  b_a += delta.segment<3>(sp::b_a);
  const double length = g.norm();
  g += delta.segment<3>(sp::g);
  if (unit_gravity) g *= length / g.norm();
}

sp::Vector SplineState::minus(const SplineState& reference) const {
  sp::Vector d;
  for (int i = 0; i < 4; ++i) {
    const Pose &here = control[static_cast<std::size_t>(i)], &there = reference.control[static_cast<std::size_t>(i)];
    d.segment<3>(sp::theta(i)) = log_so3(there.R.transpose() * here.R);
    d.segment<3>(sp::p(i)) = here.p - there.p;
  }
  d.segment<3>(sp::b_w) = b_w - reference.b_w;
  d.segment<3>(sp::b_a) = b_a - reference.b_a;
  d.segment<3>(sp::g) = g - reference.g;
  return d;
}

// eq. SPL-5.
void SplineBelief::extend(const SplineNoise& noise) {
  auto& control = x.control;
  const Mat3 turn = control[2].R.transpose() * control[3].R;
  std::rotate(control.begin(), control.begin() + 1, control.end());
  control[3] = {orthonormalised(control[2].R * turn), 2 * control[2].p - control[1].p};
  x.begin += x.interval;

  // Rows, then columns: all move up by one control pose, and the newest is made of the two before it.
  const Mat3 back = turn.transpose();
  const auto shift = [&back](sp::Matrix& X) {
    using Rows = Eigen::Matrix<double, 3, sp::kDim>;
    Rows theta = X.middleRows<3>(sp::theta(3)), p = 2 * X.middleRows<3>(sp::p(3)) - X.middleRows<3>(sp::p(2));
    theta.noalias() += back * (X.middleRows<3>(sp::theta(3)) - X.middleRows<3>(sp::theta(2)));
    for (int i = 0; i < 3; ++i) X.middleRows<6>(6 * i) = X.middleRows<6>(6 * (i + 1)).eval();
    X.middleRows<3>(sp::theta(3)) = theta;
    X.middleRows<3>(sp::p(3)) = p;
  };
  shift(P);
  P.transposeInPlace();
  shift(P);
  symmetrise(P);

  const double dt = to_seconds(x.interval);
  const double q_p = noise.acceleration * noise.acceleration * dt * dt * dt * dt;
  const double q_theta = noise.turn * noise.turn * dt * dt * dt * dt;
  for (int i = 0; i < 4; ++i) {
    const double share = i == 3 ? 1.0 : noise.kept;
    P.diagonal().segment<3>(sp::theta(i)).array() += share * q_theta;
    P.diagonal().segment<3>(sp::p(i)).array() += share * q_p;
  }
  P.diagonal().segment<3>(sp::b_w).array() += noise.gyro_bias * dt;
  P.diagonal().segment<3>(sp::b_a).array() += noise.acc_bias * dt;
}

void SplineBelief::advance(TimeNs t, const SplineNoise& noise) {
  if (t - x.end() > kLongestChain) {
    jump(t, noise);
  } else {
    extend(noise);
  }
}

// eq. SPL-6.
void SplineBelief::spread(TimeNs t, const sp::MomentMatrix& P_moment, const SplineNoise& noise) {
  const SplineMoment at = x.moment(t);
  Eigen::Matrix<double, sp::kDim, sp::kMomentDim> G = Eigen::Matrix<double, sp::kDim, sp::kMomentDim>::Zero();
  for (int i = 0; i < 4; ++i) {
    const double tau = x.after(i, t);
    G.block<3, 3>(sp::theta(i), sp::moment::theta) = exp_so3(-tau * at.w);
    G.block<3, 3>(sp::theta(i), sp::moment::w) = tau * right_jacobian_so3(tau * at.w);
    G.block<3, 3>(sp::p(i), sp::moment::p).setIdentity();
    G.block<3, 3>(sp::p(i), sp::moment::v).diagonal().setConstant(tau);
  }
  G.bottomRightCorner<9, 9>().setIdentity();
  P = G * P_moment * G.transpose();
  symmetrise(P);
  const double square = to_seconds(x.interval) * to_seconds(x.interval);
  for (int i = 0; i < 4; ++i) {
    P.diagonal().segment<3>(sp::theta(i)).array() += noise.turn * noise.turn * square * square;
    P.diagonal().segment<3>(sp::p(i)).array() += noise.acceleration * noise.acceleration * square * square;
  }
}

sp::MomentMatrix SplineBelief::moment_covariance(TimeNs t) const {
  const MomentOfControl M = moment_slopes(x, t);
  return M * P * M.transpose();
}

StateMatrix SplineBelief::nav_covariance(TimeNs t) const {
  const sp::MomentMatrix of = moment_covariance(t);
  static constexpr int kCommon[][2] = {{block::theta, sp::moment::theta}, {block::p, sp::moment::p},
                                       {block::v, sp::moment::v},         {block::b_w, sp::moment::b_w},
                                       {block::b_a, sp::moment::b_a},     {block::g, sp::moment::g}};
  StateMatrix out = StateMatrix::Zero();
  for (const auto& [row, own_row] : kCommon) {
    for (const auto& [column, own_column] : kCommon) out.block<3, 3>(row, column) = of.block<3, 3>(own_row, own_column);
  }
  return (0.5 * (out + out.transpose())).eval();
}

/// Constant velocity and rate from the end of the segment to t, with the noise that one control pose after the other
/// would have added.
void SplineBelief::jump(TimeNs t, const SplineNoise& noise) {
  const TimeNs from = x.end();
  const SplineMoment at = x.moment(from);
  const sp::MomentMatrix known = moment_covariance(from);
  const double T = to_seconds(t - from), dt = to_seconds(x.interval);
  sp::MomentMatrix F = sp::MomentMatrix::Identity();
  F.block<3, 3>(sp::moment::theta, sp::moment::theta) = exp_so3(-T * at.w);
  F.block<3, 3>(sp::moment::theta, sp::moment::w) = T * right_jacobian_so3(T * at.w);
  F.block<3, 3>(sp::moment::p, sp::moment::v).diagonal().setConstant(T);
  sp::MomentMatrix grown = F * known * F.transpose();
  const double q_p = noise.acceleration * noise.acceleration * dt, q_theta = noise.turn * noise.turn * dt;
  grown.diagonal().segment<3>(sp::moment::theta).array() += q_theta * T * T * T / 3;
  grown.diagonal().segment<3>(sp::moment::w).array() += q_theta * T;
  grown.diagonal().segment<3>(sp::moment::p).array() += q_p * T * T * T / 3;
  grown.diagonal().segment<3>(sp::moment::v).array() += q_p * T;
  grown.diagonal().segment<3>(sp::moment::b_w).array() += noise.gyro_bias * T;
  grown.diagonal().segment<3>(sp::moment::b_a).array() += noise.acc_bias * T;
  x.set(t, {at.R * exp_so3(T * at.w), at.p + T * at.v}, at.v, at.w);
  spread(t, grown, noise);
}

Vec6 SplineInformation::add_point(const SplineSlopes& slopes, const Mat3& R, const Vec3& p_I, const Vec3& u, double z,
                                  double information) {
  Vec6 seen;
  seen << p_I.cross(R.transpose() * u), u;
  Eigen::Matrix<double, sp::kControl, 1> h;
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    h.segment<3>(sp::theta(i)).noalias() = slopes.theta[k].transpose() * seen.head<3>();
    h.segment<3>(sp::p(i)) = slopes.p[k] * u;
  }
  const Eigen::Matrix<double, sp::kControl, 1> weighted = information * h;
  for (int column = 0; column < sp::kControl; ++column) {  // in whole vectors
    A.col(column).head<sp::kControl>() += h[column] * weighted;
  }
  b.head<sp::kControl>() += z * weighted;
  weighted_sum += z * z * information;
  ++rows;
  return seen;
}

void SplineInformation::add(const sp::Vector& h, double z, double information) {
  const sp::Vector weighted = information * h;
  for (int column = 0; column < sp::kDim; ++column) A.col(column) += h[column] * weighted;
  b += z * weighted;
  weighted_sum += z * z * information;
  ++rows;
}

// eq. SPL-7.
void SplineInformation::add_gyro(const SplineMoment& at, const SplineSlopes& slopes, const SplineState& x,
                                 const ImuSample& sample, unsigned axes, double variance) {
  const Vec3 z = at.w + x.b_w - sample.gyro;
  for (int axis = 0; axis < 3; ++axis) {
    if ((axes & (1U << axis)) == 0) continue;
    sp::Vector h = sp::Vector::Zero();
    for (int i = 0; i < 4; ++i) {
      h.segment<3>(sp::theta(i)) = slopes.w[static_cast<std::size_t>(i)].row(axis).transpose();
    }
    h[sp::b_w + axis] = 1;
    add(h, z[axis], 1.0 / variance);
  }
}

void SplineInformation::add_acc(const SplineMoment& at, const SplineSlopes& slopes, const SplineState& x,
                                const ImuSample& sample, unsigned axes, double variance) {
  const Vec3 force = at.R.transpose() * (at.a_W - x.g);
  const Vec3 z = force + x.b_a - sample.acc;
  const Mat3 by_theta = hat(force);
  for (int axis = 0; axis < 3; ++axis) {
    if ((axes & (1U << axis)) == 0) continue;
    sp::Vector h = sp::Vector::Zero();
    const Vec3 u = at.R.col(axis);
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<std::size_t>(i);
      h.segment<3>(sp::theta(i)) = slopes.theta[k].transpose() * by_theta.row(axis).transpose();
      h.segment<3>(sp::p(i)) = slopes.a_W[k] * u;
    }
    h.segment<3>(sp::g) = -u;
    h[sp::b_a + axis] = 1;
    add(h, z[axis], 1.0 / variance);
  }
}

// eq. SPL-8.
SplineStep::SplineStep(const sp::Matrix& prior, const sp::Vector& d, const SplineInformation& information) {
  sp::Matrix seen = prior;  // from the iterate, eq. IESKF-3
  for (int i = 0; i < 4; ++i) {
    const Mat3 J = right_jacobian_so3(d.segment<3>(sp::theta(i)));
    seen.middleRows<3>(sp::theta(i)) = (J * seen.middleRows<3>(sp::theta(i))).eval();
    seen.middleCols<3>(sp::theta(i)) = (seen.middleCols<3>(sp::theta(i)) * J.transpose()).eval();
  }
  sp::Matrix system = sp::Matrix::Identity();
  system.noalias() += seen * information.A;
  const Eigen::PartialPivLU<sp::Matrix> solver(system);
  delta = -solver.solve(seen * information.b + d);
  P = solver.solve(seen);
  symmetrise(P);
}

double squared_innovation(const sp::Matrix& P, const SplineInformation& information) {
  sp::Matrix system = sp::Matrix::Identity();
  system.noalias() += P * information.A;
  const sp::Vector known = Eigen::PartialPivLU<sp::Matrix>(system).solve(P * information.b);
  return information.weighted_sum - information.b.dot(known);
}

}  // namespace aslio::plugins
