#include "estimators/cubic_spline.hpp"

#include <Eigen/Geometry>

namespace aslio::plugins {

// eq. SPL-1.
CumulativeBasis::CumulativeBasis(double u, double interval) {
  const double u2 = u * u, u3 = u2 * u, rate = 1.0 / interval;
  value = Vec3(5 + 3 * u - 3 * u2 + u3, 1 + 3 * u + 3 * u2 - 2 * u3, u3) / 6.0;
  first = rate * Vec3(1 - 2 * u + u2, 1 + 2 * u - 2 * u2, u2) / 2.0;
  second = rate * rate * Vec3(u - 1, 1 - 2 * u, u);
}

CubicSplineSegment::CubicSplineSegment(const ControlPoses& control, double interval)
    : interval_(interval), control_(control) {
  for (std::size_t j = 0; j < 3; ++j) turn_[j] = log_so3(control[j].R.transpose() * control[j + 1].R);
}

Pose CubicSplineSegment::pose(double u) const {
  const CumulativeBasis basis(u, interval_);
  Pose out = control_[0];
  for (std::size_t j = 0; j < 3; ++j) {
    const double share = basis.value[static_cast<Eigen::Index>(j)];
    out.R *= exp_so3(share * turn_[j]);
    out.p += share * (control_[j + 1].p - control_[j].p);
  }
  return out;
}

// eq. SPL-2.
SplineMoment CubicSplineSegment::at(double u) const {
  const CumulativeBasis basis(u, interval_);
  SplineMoment out;
  out.R = control_[0].R;
  out.p = control_[0].p;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const Vec3 step = control_[j + 1].p - control_[j].p;
    out.p += basis.value[k] * step;
    out.v += basis.first[k] * step;
    out.a_W += basis.second[k] * step;
    const Mat3 turned = exp_so3(basis.value[k] * turn_[j]);
    out.R *= turned;
    out.w = turned.transpose() * out.w + basis.first[k] * turn_[j];
    out.w_dot = turned.transpose() * out.w_dot + basis.first[k] * out.w.cross(turn_[j]) + basis.second[k] * turn_[j];
  }
  return out;
}

namespace {

/// Weights of the control points themselves, from cumulative ones of which the first is `whole`.
std::array<double, 4> point_weights(double whole, const Vec3& cumulative) {
  return {whole - cumulative[0], cumulative[0] - cumulative[1], cumulative[1] - cumulative[2], cumulative[2]};
}

}  // namespace

// eq. SPL-3.
SplineSlopes CubicSplineSegment::slopes(double u) const {
  const CumulativeBasis basis(u, interval_);
  SplineSlopes out;
  out.p = point_weights(1, basis.value);
  out.v = point_weights(0, basis.first);
  out.a_W = point_weights(0, basis.second);
  std::array<Mat3, 3> turned, by_turn, rate_by_turn;
  Vec3 w = Vec3::Zero();
  for (std::size_t j = 0; j < 3; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const Vec3 part = basis.value[k] * turn_[j];
    turned[j] = exp_so3(part);
    by_turn[j] = basis.value[k] * right_jacobian_so3(part);
    const Vec3 before = turned[j].transpose() * w;
    rate_by_turn[j] = hat(before) * by_turn[j];
    rate_by_turn[j].diagonal().array() += basis.first[k];
    w = before + basis.first[k] * turn_[j];
  }
  Mat3 after = Mat3::Identity();  // turns of what comes later, transposed
  for (Mat3& slope : out.theta) slope.setZero();
  for (Mat3& slope : out.w) slope.setZero();
  for (std::size_t j = 3; j-- > 0;) {
    const Mat3 by_new = right_jacobian_inverse_so3(turn_[j]);  // of the turn, by the error of its end
    const Mat3 by_old = -by_new.transpose();                   // and of its begin: J_l^-1 is the transpose of J_r^-1
    const Mat3 theta = after * by_turn[j], rate = after * rate_by_turn[j];
    out.theta[j + 1] += theta * by_new;
    out.theta[j] += theta * by_old;
    out.w[j + 1] += rate * by_new;
    out.w[j] += rate * by_old;
    after *= turned[j].transpose();
  }
  out.theta[0] += after;
  return out;
}

}  // namespace aslio::plugins
