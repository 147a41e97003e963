#pragma once
/// SO(3) and SE(3) with right perturbation: R <- R Exp(dtheta). Small-angle safe everywhere.
/// Notation and derivations: docs/notation.md, docs/equations.md (tags LIE-1 ...).

#include <Eigen/Core>

namespace aslio {

using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// hat(a) b = a x b.
Mat3 hat(const Vec3& a);

/// Rotation of angle |phi| [rad] about phi.
Mat3 exp_so3(const Vec3& phi);
/// Inverse of exp_so3, |result| <= pi.
Vec3 log_so3(const Mat3& R);
/// Exp(phi + d) = Exp(phi) Exp(J_r(phi) d) + O(d^2).
Mat3 right_jacobian_so3(const Vec3& phi);
Mat3 right_jacobian_inverse_so3(const Vec3& phi);
/// J_l(phi) = J_r(-phi).
Mat3 left_jacobian_so3(const Vec3& phi);
Mat3 left_jacobian_inverse_so3(const Vec3& phi);
/// Nearest rotation to a matrix that has drifted by rounding (one Newton step of the polar decomposition).
Mat3 orthonormalised(const Mat3& R);

/// Rigid transform T_A_B: p_A = R p_B + p.
struct Pose {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();

  Pose operator*(const Pose& other) const { return {R * other.R, R * other.p + p}; }
  Vec3 operator*(const Vec3& x) const { return R * x + p; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// SE(3), tangent order (theta [rad], rho [m]), T <- T Exp(xi).
Pose exp_se3(const Vec6& xi);
Vec6 log_se3(const Pose& T);
Mat6 right_jacobian_se3(const Vec6& xi);
Mat6 right_jacobian_inverse_se3(const Vec6& xi);
Mat6 left_jacobian_se3(const Vec6& xi);
Mat6 left_jacobian_inverse_se3(const Vec6& xi);

/// Interpolation on SO(3) x R^3: rotation by SLERP, position linearly; u in [0, 1].
Pose interpolate(const Pose& a, const Pose& b, double u);

}  // namespace aslio
