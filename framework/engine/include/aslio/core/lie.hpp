#pragma once
/// SO(3) and SE(3) with right perturbation: R <- R Exp(dtheta). Small-angle safe everywhere.
/// Notation and derivations: docs/notation.md, docs/equations.md (tags LIE-1 ...).

#include <Eigen/Core>
#include <cmath>

namespace aslio {

using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;

namespace detail {

/// Coefficients of I + first hat(phi) + second hat(phi)^2.
struct So3Coefficients {
  double first;
  double second;
};

/// The matrix I + first hat(phi) + second hat(phi)^2, written out: it costs half of the matrix product.
inline Mat3 so3_series(const Vec3& phi, const So3Coefficients& c) {
  const double x = phi.x(), y = phi.y(), z = phi.z();
  const double xy = c.second * x * y, xz = c.second * x * z, yz = c.second * y * z;
  Mat3 M;
  M << 1.0 - c.second * (y * y + z * z), xy - c.first * z, xz + c.first * y,  //
      xy + c.first * z, 1.0 - c.second * (x * x + z * z), yz - c.first * x,   //
      xz - c.first * y, yz + c.first * x, 1.0 - c.second * (x * x + y * y);
  return M;
}

/// Squared angle [rad^2] below which the series are used. At this angle the closed forms have lost 3 digits to
/// cancellation and the series, cut after the 8th power, have not lost any. It also spares the per-IMU-sample and
/// per-point callers the trigonometric functions.
inline constexpr double kSmallAngleSquared = 0.01;

/// sin(t)/t, (1 - cos t)/t^2, (t - sin t)/t^3 of t^2.
struct SineRatios {
  double sin_1;
  double cos_2;
  double sin_3;
};

inline SineRatios sine_ratios(double t2) {
  if (t2 < kSmallAngleSquared) {
    return {1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0))),
            0.5 * (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0 * (1.0 - t2 / 90.0)))),
            1.0 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0 * (1.0 - t2 / 110.0))))};
  }
  const double t = std::sqrt(t2);
  const double s = std::sin(t);
  const double h = std::sin(0.5 * t);
  return {s / t, 2.0 * h * h / t2, (t - s) / (t2 * t)};
}

}  // namespace detail

/// hat(a) b = a x b.
inline Mat3 hat(const Vec3& a) {
  Mat3 A;
  A << 0.0, -a.z(), a.y(),  //
      a.z(), 0.0, -a.x(),   //
      -a.y(), a.x(), 0.0;
  return A;
}

/// Rotation of angle |phi| [rad] about phi. eq. LIE-1
inline Mat3 exp_so3(const Vec3& phi) {
  const detail::SineRatios r = detail::sine_ratios(phi.squaredNorm());
  return detail::so3_series(phi, {r.sin_1, r.cos_2});
}
/// Inverse of exp_so3, |result| <= pi. eq. LIE-2
Vec3 log_so3(const Mat3& R);
/// Exp(phi + d) = Exp(phi) Exp(J_r(phi) d) + O(d^2). eq. LIE-3
inline Mat3 right_jacobian_so3(const Vec3& phi) {
  const detail::SineRatios r = detail::sine_ratios(phi.squaredNorm());
  return detail::so3_series(phi, {-r.cos_2, r.sin_3});
}
/// Defined for |phi| < 2 pi. eq. LIE-4
Mat3 right_jacobian_inverse_so3(const Vec3& phi);
/// J_l(phi) = J_r(-phi).
inline Mat3 left_jacobian_so3(const Vec3& phi) { return right_jacobian_so3(-phi); }
/// Defined for |phi| < 2 pi.
Mat3 left_jacobian_inverse_so3(const Vec3& phi);
/// Nearest rotation to a matrix that has drifted by rounding (one Newton step of the polar decomposition). eq. LIE-5
Mat3 orthonormalised(const Mat3& R);

/// Rigid transform T_A_B: p_A = R p_B + p.
struct Pose {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();

  Pose operator*(const Pose& other) const { return {R * other.R, R * other.p + p}; }
  Vec3 operator*(const Vec3& x) const { return R * x + p; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
  /// This pose moved by xi = (theta [rad], dp [m]): R Exp(theta), p + dp.
  Pose moved(const Vec6& xi) const { return {R * exp_so3(xi.head<3>()), p + xi.tail<3>()}; }
};

/// SE(3), tangent order (theta [rad], rho [m]), T <- T Exp(xi). eq. LIE-6
Pose exp_se3(const Vec6& xi);
/// Inverse of exp_se3, |theta| <= pi.
Vec6 log_se3(const Pose& T);
/// Exp(xi + d) = Exp(xi) Exp(J_r(xi) d) + O(d^2); J_l(xi) = J_r(-xi). eq. LIE-7, LIE-8
Mat6 right_jacobian_se3(const Vec6& xi);
/// The inverses are defined for |theta| < 2 pi.
Mat6 right_jacobian_inverse_se3(const Vec6& xi);
Mat6 left_jacobian_se3(const Vec6& xi);
Mat6 left_jacobian_inverse_se3(const Vec6& xi);

/// Interpolation on SO(3) x R^3: rotation by SLERP, position linearly; u in [0, 1]; exactly a and b at the ends.
/// eq. LIE-9
Pose interpolate(const Pose& a, const Pose& b, double u);

}  // namespace aslio
