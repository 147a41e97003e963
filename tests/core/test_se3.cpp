#include <catch2/catch.hpp>
#include <numbers>

#include "aslio/core/lie.hpp"
#include "core/directions.hpp"

namespace {

using namespace aslio;
using test::directions;

const double kAngles[] = {0.0, 1e-10, 1e-4, 0.0999, 0.1001, 0.4999, 0.5001, 1.3, 3.0};

Vec6 twist(const Vec3& theta, const Vec3& rho) {
  Vec6 xi;
  xi << theta, rho;
  return xi;
}

template <class Matrix>
double distance(const Matrix& a, const Matrix& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

double distance(const Pose& a, const Pose& b) { return std::max(distance(a.R, b.R), (a.p - b.p).norm()); }

/// Calls f for twists of every tested angle, each axis, and positions along, across and oblique to it.
template <class F>
void for_each_twist(F&& f) {
  for (const double angle : kAngles) {
    for (const Vec3& axis : directions()) {
      INFO("angle " << angle << ", axis " << axis.transpose());
      f(twist(angle * axis, Vec3(0.3, -1.7, 2.2)));
      f(twist(angle * axis, 5.0 * axis));
    }
  }
}

}  // namespace

TEST_CASE("Pose composes, inverts and acts") {
  const Pose a{exp_so3(Vec3(0.1, 0.2, -0.3)), Vec3(1, 2, 3)};
  const Pose b{exp_so3(Vec3(-1.0, 0.5, 0.2)), Vec3(-4, 0, 1)};
  const Vec3 x(0.3, -0.2, 7.0);
  CHECK(((a * b) * x - a * (b * x)).norm() < 1e-14);
  CHECK(distance(a * a.inverse(), Pose{}) < 1e-15);
  CHECK(distance((a * b).inverse(), b.inverse() * a.inverse()) < 1e-14);
}

TEST_CASE("a screw motion: half a turn about z while 2 m are climbed") {
  const Pose T = exp_se3(twist(Vec3(0, 0, std::numbers::pi), Vec3(std::numbers::pi, 0, 2)));
  CHECK((T.p - Vec3(0, 2, 2)).norm() < 1e-14);  // a half circle of radius 1 m ends 2 m to the left
  CHECK((T.R - exp_so3(Vec3(0, 0, std::numbers::pi))).norm() == 0.0);
}

TEST_CASE("log undoes exp on SE(3)") {  // eq. LIE-6
  for_each_twist([](const Vec6& xi) { CHECK((log_se3(exp_se3(xi)) - xi).norm() < 1e-13); });
}

TEST_CASE("Jacobians of SE(3) against central differences") {  // eq. LIE-7
  constexpr double h = 1e-5;
  for_each_twist([&](const Vec6& xi) {
    const Pose T = exp_se3(xi);
    Mat6 right, left;
    for (int i = 0; i < 6; ++i) {
      const Vec6 d = h * Vec6::Unit(i);
      right.col(i) = (log_se3(T.inverse() * exp_se3(xi + d)) - log_se3(T.inverse() * exp_se3(xi - d))) / (2.0 * h);
      left.col(i) = (log_se3(exp_se3(xi + d) * T.inverse()) - log_se3(exp_se3(xi - d) * T.inverse())) / (2.0 * h);
    }
    CHECK(distance(right_jacobian_se3(xi), right) < 2e-9);
    CHECK(distance(left_jacobian_se3(xi), left) < 2e-9);
  });
}

TEST_CASE("inverse Jacobians of SE(3) invert, and the Jacobian leaves its own twist") {
  for_each_twist([&](const Vec6& xi) {
    CHECK(distance<Mat6>(right_jacobian_se3(xi) * right_jacobian_inverse_se3(xi), Mat6::Identity()) < 1e-12);
    CHECK(distance<Mat6>(left_jacobian_inverse_se3(xi) * left_jacobian_se3(xi), Mat6::Identity()) < 1e-12);
    CHECK((right_jacobian_se3(xi) * xi - xi).norm() < 1e-13);
  });
}

TEST_CASE("series and closed forms of the Q block agree where they meet") {  // eq. LIE-8
  for (const Vec3& axis : directions()) {
    const Vec3 rho(0.3, -1.7, 2.2);
    const Mat6 below = left_jacobian_se3(twist((0.5 - 1e-14) * axis, rho));
    const Mat6 above = left_jacobian_se3(twist((0.5 + 1e-14) * axis, rho));
    CHECK(distance(below, above) < 1e-12);
  }
}

TEST_CASE("interpolate is exact at the ends, linear in angle and position between") {  // eq. LIE-9
  const Pose a{exp_so3(Vec3(0.1, 0.2, -0.3)), Vec3(1, 2, 3)};
  const Vec3 turn(0.4, -0.6, 2.0);
  const Pose b{a.R * exp_so3(turn), Vec3(-4, 0, 1)};
  CHECK(distance(interpolate(a, b, 0.0), a) == 0.0);
  CHECK(distance(interpolate(a, b, 1.0), b) == 0.0);
  for (const double u : {0.1, 0.5, 0.875}) {
    const Pose T = interpolate(a, b, u);
    CHECK((log_so3(a.R.transpose() * T.R) - u * turn).norm() < 1e-14);
    CHECK((T.p - (a.p + u * (b.p - a.p))).norm() < 1e-14);
    CHECK(distance(interpolate(b, a, 1.0 - u), T) < 1e-14);
  }
}
