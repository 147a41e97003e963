#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/core/lie.hpp"
#include "core/directions.hpp"

namespace {

using namespace aslio;
using test::directions;

// Both sides of the branch of the series (0.1 rad), the smallest numbers, and both sides of pi.
const double kAngles[] = {0.0,      1e-300,   1e-18, 1e-9, 1e-6, 1e-3, 0.03, 0.09,   0.0999,   0.1,
                          0.100001, 0.100002, 0.5,   1.0,  2.0,  3.0,  3.14, 3.1415, 3.141592, 3.1415926535};

double distance(const Mat3& a, const Mat3& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// d/dd of Log(Exp(phi)^T Exp(phi + d)) by central differences.
Mat3 numeric_right_jacobian(const Vec3& phi) {
  constexpr double h = 1e-5;
  Mat3 J;
  for (int i = 0; i < 3; ++i) {
    const Vec3 d = h * Vec3::Unit(i);
    const Mat3 inverse = exp_so3(phi).transpose();
    J.col(i) = (log_so3(inverse * exp_so3(phi + d)) - log_so3(inverse * exp_so3(phi - d))) / (2.0 * h);
  }
  return J;
}

}  // namespace

TEST_CASE("hat is the cross product") {
  const Vec3 a(1.5, -2.0, 0.25), b(-0.5, 3.0, 4.0);
  CHECK((hat(a) * b - a.cross(b)).norm() < 1e-15);
  CHECK(hat(a) == Mat3(-hat(a).transpose()));
}

TEST_CASE("exp of a quarter turn about z takes x to y") {  // eq. LIE-1
  const Mat3 R = exp_so3(Vec3(0, 0, 0.5 * std::numbers::pi));
  CHECK((R * Vec3::UnitX() - Vec3::UnitY()).norm() < 1e-15);
  CHECK((R * Vec3::UnitZ() - Vec3::UnitZ()).norm() < 1e-15);
}

TEST_CASE("exp gives rotations and log undoes exp, near zero and near pi") {  // eqs. LIE-1, LIE-2
  for (const double angle : kAngles) {
    for (const Vec3& axis : directions()) {
      const Vec3 phi = angle * axis;
      const Mat3 R = exp_so3(phi);
      INFO("angle " << angle << ", axis " << axis.transpose());
      CHECK(distance(R * R.transpose(), Mat3::Identity()) < 1e-14);
      CHECK(R.determinant() == Approx(1.0).epsilon(1e-14));
      CHECK((log_so3(R) - phi).norm() <= 1e-14 + 1e-13 * angle);
    }
  }
}

TEST_CASE("log keeps all digits of the smallest angles") {  // eq. LIE-2
  for (const Vec3& axis : directions()) {
    const Vec3 phi = 1e-12 * axis;
    CHECK((log_so3(exp_so3(phi)) - phi).norm() < 1e-26);
  }
  CHECK(log_so3(Mat3::Identity()) == Vec3::Zero());
}

TEST_CASE("at pi exactly, log gives one of the two vectors whose exp it is") {
  for (const Vec3& axis : directions()) {
    const Mat3 R = 2.0 * axis * axis.transpose() - Mat3::Identity();  // the exact half turn
    const Vec3 phi = log_so3(R);
    CHECK(phi.norm() == Approx(std::numbers::pi).epsilon(1e-14));
    CHECK(distance(exp_so3(phi), R) < 1e-14);
  }
}

TEST_CASE("beyond pi, log gives the shorter way round") {
  for (const Vec3& axis : directions()) {
    const Vec3 phi = log_so3(exp_so3(4.0 * axis));
    CHECK((phi - (4.0 - 2.0 * std::numbers::pi) * axis).norm() < 1e-14);
  }
}

TEST_CASE("series and closed forms agree at the angle where they meet") {
  const double t2 = detail::kSmallAngleSquared;
  const auto below = detail::sine_ratios(std::nextafter(t2, 0.0));
  const auto above = detail::sine_ratios(t2);
  CHECK(std::abs(below.sin_1 - above.sin_1) < 1e-12);
  CHECK(std::abs(below.cos_2 - above.cos_2) < 1e-12);
  CHECK(std::abs(below.sin_3 - above.sin_3) < 1e-12);
  const double t = std::sqrt(t2);
  for (const Vec3& axis : directions()) {
    const Vec3 low = (t - 1e-14) * axis, high = (t + 1e-14) * axis;
    CHECK(distance(right_jacobian_inverse_so3(low), right_jacobian_inverse_so3(high)) < 1e-12);
  }
}

TEST_CASE("right Jacobian of SO(3) against central differences") {  // eq. LIE-3
  for (const double angle : {0.0, 1e-9, 1e-3, 0.0999, 0.1001, 0.7, 2.0, 3.0}) {
    for (const Vec3& axis : directions()) {
      const Vec3 phi = angle * axis;
      INFO("angle " << angle);
      CHECK(distance(right_jacobian_so3(phi), numeric_right_jacobian(phi)) < 1e-9);
    }
  }
}

TEST_CASE("left Jacobian of SO(3) against central differences") {
  constexpr double h = 1e-5;
  const Vec3 phi(0.4, -1.1, 0.8);
  Mat3 J;
  for (int i = 0; i < 3; ++i) {
    const Vec3 d = h * Vec3::Unit(i);
    const Mat3 inverse = exp_so3(phi).transpose();
    J.col(i) = (log_so3(exp_so3(phi + d) * inverse) - log_so3(exp_so3(phi - d) * inverse)) / (2.0 * h);
  }
  CHECK(distance(left_jacobian_so3(phi), J) < 1e-9);
}

TEST_CASE("identities of the Jacobians of SO(3)") {  // eqs. LIE-3, LIE-4
  for (const double angle : {0.0, 1e-12, 1e-4, 0.0999, 0.1001, 1.0, 3.0, 3.1415926, 6.0}) {
    for (const Vec3& axis : directions()) {
      const Vec3 phi = angle * axis;
      INFO("angle " << angle);
      CHECK((right_jacobian_so3(phi) * phi - phi).norm() < 1e-14 * (1.0 + angle));
      CHECK(distance(left_jacobian_so3(phi), right_jacobian_so3(-phi)) == 0.0);
      CHECK(distance(left_jacobian_so3(phi), exp_so3(phi) * right_jacobian_so3(phi)) < 1e-13);
      // Near 2 pi the inverse grows as 1 / (2 pi - angle), and its rounding with it.
      CHECK(distance(right_jacobian_inverse_so3(phi) * right_jacobian_so3(phi), Mat3::Identity()) < 1e-12);
      CHECK(distance(left_jacobian_inverse_so3(phi) * left_jacobian_so3(phi), Mat3::Identity()) < 1e-12);
    }
  }
}

TEST_CASE("orthonormalised squares the drift away and keeps a rotation") {  // eq. LIE-5
  const Mat3 R = exp_so3(Vec3(0.3, -0.7, 1.9));
  Mat3 noise;
  noise << 1, -2, 0.5, 0.25, -1, 2, -0.75, 1.5, 1;
  const Mat3 drifted = R + 1e-6 * noise;
  CHECK(distance(drifted * drifted.transpose(), Mat3::Identity()) > 1e-7);
  const Mat3 fixed = orthonormalised(drifted);
  CHECK(distance(fixed * fixed.transpose(), Mat3::Identity()) < 1e-10);
  CHECK(distance(fixed, R) < 1e-5);
  CHECK(distance(orthonormalised(R), R) < 1e-15);
}
