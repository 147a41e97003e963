#include "aslio/core/lie.hpp"

#include <Eigen/Geometry>

namespace aslio {

namespace {

/// (1 - (t/2) cot(t/2)) / t^2, the coefficient of hat^2 in the inverse Jacobians. eq. LIE-4
double inverse_jacobian_coefficient(double t2) {
  if (t2 < detail::kSmallAngleSquared) {
    return 1.0 / 12.0 + t2 * (1.0 / 720.0 + t2 * (1.0 / 30240.0 + t2 * (1.0 / 1209600.0 + t2 / 47900160.0)));
  }
  const double half = 0.5 * std::sqrt(t2);
  return (1.0 - half * std::cos(half) / std::sin(half)) / t2;
}

/// Coefficients of the fourth and fifth order terms of Q. eq. LIE-8
struct QCoefficients {
  double fourth;  ///< (t^2/2 + cos t - 1) / t^4
  double fifth;   ///< (2 t - 3 sin t + t cos t) / (2 t^5)
};

QCoefficients q_coefficients(double t2) {
  // The closed forms lose digits as eps/t^4, so the series reach further than those of SO(3).
  if (t2 < 0.25) {
    double fourth = 0.0;
    double fifth = 0.0;
    double factorial = 24.0;  // (2k)!
    double power = 1.0;       // (-t^2)^(k-2)
    for (int k = 2; k <= 8; ++k) {
      fourth += power / factorial;
      fifth += power * (k - 1) / (factorial * (2 * k + 1));
      factorial *= (2.0 * k + 1.0) * (2.0 * k + 2.0);
      power *= -t2;
    }
    return {fourth, fifth};
  }
  const double t = std::sqrt(t2);
  const double s = std::sin(t);
  const double c = std::cos(t);
  return {(0.5 * t2 + c - 1.0) / (t2 * t2), (2.0 * t - 3.0 * s + t * c) / (2.0 * t2 * t2 * t)};
}

/// Lower left block of the left Jacobian of SE(3). eq. LIE-8, Barfoot, State Estimation for Robotics, (7.86)
Mat3 q_block(const Vec3& theta, const Vec3& rho) {
  const double t2 = theta.squaredNorm();
  const double third = detail::sine_ratios(t2).sin_3;
  const QCoefficients c = q_coefficients(t2);
  const Mat3 A = hat(theta);
  const Mat3 B = hat(rho);
  const Mat3 AB = A * B;
  const Mat3 BA = B * A;
  const Mat3 ABA = AB * A;
  return 0.5 * B + third * (AB + BA + ABA) + c.fourth * (A * AB + BA * A - 3.0 * ABA) + c.fifth * (ABA * A + A * ABA);
}

}  // namespace

Vec3 log_so3(const Mat3& R) {
  // By the quaternion: Shepperd's choice of the largest component keeps all digits near 0 and near pi alike. eq. LIE-2
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double n = q.vec().norm();
  // Below this n, atan2(n, w) = n / w to the last bit, and n may have underflowed.
  if (n < 1e-9) return (2.0 / q.w()) * q.vec();
  return (2.0 * std::atan2(n, q.w()) / n) * q.vec();
}

Mat3 right_jacobian_inverse_so3(const Vec3& phi) {
  return detail::so3_series(phi, {0.5, inverse_jacobian_coefficient(phi.squaredNorm())});
}

Mat3 left_jacobian_inverse_so3(const Vec3& phi) { return right_jacobian_inverse_so3(-phi); }

Mat3 orthonormalised(const Mat3& R) { return 0.5 * R * (3.0 * Mat3::Identity() - R.transpose() * R); }

Pose exp_se3(const Vec6& xi) {
  const Vec3 theta = xi.head<3>();
  return {exp_so3(theta), left_jacobian_so3(theta) * xi.tail<3>()};
}

Vec6 log_se3(const Pose& T) {
  const Vec3 theta = log_so3(T.R);
  Vec6 xi;
  xi << theta, left_jacobian_inverse_so3(theta) * T.p;
  return xi;
}

Mat6 left_jacobian_se3(const Vec6& xi) {
  const Vec3 theta = xi.head<3>();
  const Mat3 J = left_jacobian_so3(theta);
  Mat6 M = Mat6::Zero();
  M.topLeftCorner<3, 3>() = J;
  M.bottomRightCorner<3, 3>() = J;
  M.bottomLeftCorner<3, 3>() = q_block(theta, xi.tail<3>());
  return M;
}

Mat6 left_jacobian_inverse_se3(const Vec6& xi) {
  const Vec3 theta = xi.head<3>();
  const Mat3 J = left_jacobian_inverse_so3(theta);
  Mat6 M = Mat6::Zero();
  M.topLeftCorner<3, 3>() = J;
  M.bottomRightCorner<3, 3>() = J;
  M.bottomLeftCorner<3, 3>() = -J * q_block(theta, xi.tail<3>()) * J;
  return M;
}

Mat6 right_jacobian_se3(const Vec6& xi) { return left_jacobian_se3(-xi); }

Mat6 right_jacobian_inverse_se3(const Vec6& xi) { return left_jacobian_inverse_se3(-xi); }

Pose interpolate(const Pose& a, const Pose& b, double u) {
  if (u <= 0.0) return a;
  if (u >= 1.0) return b;
  return {a.R * exp_so3(u * log_so3(a.R.transpose() * b.R)), (1.0 - u) * a.p + u * b.p};  // eq. LIE-9
}

}  // namespace aslio
