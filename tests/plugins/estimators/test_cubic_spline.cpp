// A segment of the cubic B-spline of pose against central differences, and against motions that it holds exactly.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "estimators/cubic_spline.hpp"
#include "plugins/estimators/spline_motion.hpp"

using namespace aslio;
using namespace aslio::test;
using namespace aslio::plugins;

namespace {

constexpr double kInterval = 0.02;  // [s]

double step_between(const Pose& a, const Pose& b) { return (a.p - b.p).norm() + log_so3(a.R.transpose() * b.R).norm(); }

}  // namespace

// eq. SPL-1.
TEST_CASE("the cumulative weights of a cubic B-spline begin and end where those of the next segment do") {
  const CumulativeBasis begin(0, kInterval), end(1, kInterval);
  CHECK((begin.value - Vec3(5.0 / 6, 1.0 / 6, 0)).norm() < 1e-15);
  CHECK((end.value - Vec3(1, 5.0 / 6, 1.0 / 6)).norm() < 1e-15);
  for (const double u : {0.0, 0.2, 0.7, 1.0}) {
    constexpr double h = 1e-6;
    const CumulativeBasis at(u, kInterval), up(u + h, kInterval), down(u - h, kInterval);
    CHECK(((up.value - down.value) / (2 * h * kInterval) - at.first).norm() < 1e-7);
    CHECK(((up.first - down.first) / (2 * h * kInterval) - at.second).norm() < 1e-5);
    CHECK(at.first.sum() == Approx(1 / kInterval));  // a line stays a line
  }
}

// eq. SPL-2.
TEST_CASE("velocity, rate and their derivatives of a spline are those of its pose") {
  std::mt19937_64 engine(3);
  for (int trial = 0; trial < 20; ++trial) {
    const CubicSplineSegment segment(some_control_poses(engine), kInterval);
    for (const double u : {0.1, 0.5, 0.9}) {
      constexpr double h = 1e-4;
      const double dt = 2 * h * kInterval;
      const SplineMoment at = segment.at(u), up = segment.at(u + h), down = segment.at(u - h);
      CHECK(step_between(at.pose(), segment.pose(u)) < 1e-12);
      CHECK(((up.p - down.p) / dt - at.v).norm() < 1e-5 * (1 + at.v.norm()));
      CHECK(((up.v - down.v) / dt - at.a_W).norm() < 1e-5 * (1 + at.a_W.norm()));
      CHECK((log_so3(down.R.transpose() * up.R) / dt - at.w).norm() < 1e-5 * (1 + at.w.norm()));
      CHECK(((up.w - down.w) / dt - at.w_dot).norm() < 1e-5 * (1 + at.w_dot.norm()));
    }
  }
}

// eq. SPL-3.
TEST_CASE("the slopes of a spline by its control poses agree with central differences") {
  std::mt19937_64 engine(5);
  for (int trial = 0; trial < 20; ++trial) {
    const ControlPoses control = some_control_poses(engine);
    for (const double u : {0.0, 0.3, 1.0}) {
      const SplineMoment at = CubicSplineSegment(control, kInterval).at(u);
      const SplineSlopes slopes = CubicSplineSegment(control, kInterval).slopes(u);
      constexpr double h = 1e-6;
      for (std::size_t i = 0; i < 4; ++i) {
        for (int axis = 0; axis < 6; ++axis) {
          const auto moved = [&](double step) {
            ControlPoses other = control;
            other[i] = other[i].moved(step * Vec6::Unit(axis));
            return CubicSplineSegment(other, kInterval).at(u);
          };
          const SplineMoment up = moved(h), down = moved(-h);
          const Vec3 theta = (log_so3(at.R.transpose() * up.R) - log_so3(at.R.transpose() * down.R)) / (2 * h);
          const Vec3 w = (up.w - down.w) / (2 * h);
          const Vec3 p = (up.p - down.p) / (2 * h), v = (up.v - down.v) / (2 * h), a = (up.a_W - down.a_W) / (2 * h);
          if (axis < 3) {
            REQUIRE((theta - slopes.theta[i].col(axis)).norm() < 1e-7);
            REQUIRE((w - slopes.w[i].col(axis)).norm() < 1e-5);
            REQUIRE(p.norm() + v.norm() + a.norm() < 1e-9);
          } else {
            const Vec3 unit = Vec3::Unit(axis - 3);
            REQUIRE(theta.norm() + w.norm() < 1e-9);
            REQUIRE((p - slopes.p[i] * unit).norm() < 1e-7);
            REQUIRE((v - slopes.v[i] * unit).norm() < 1e-5);
            REQUIRE((a - slopes.a_W[i] * unit).norm() < 1e-3);
          }
        }
      }
    }
  }
}

TEST_CASE("two segments that share three control poses meet in pose, velocity, rate and their derivatives") {
  std::mt19937_64 engine(9);
  const ControlPoses first = some_control_poses(engine);
  const ControlPoses second{first[1], first[2], first[3], some_control_poses(engine)[2]};
  const SplineMoment end = CubicSplineSegment(first, kInterval).at(1),
                     begin = CubicSplineSegment(second, kInterval).at(0);
  CHECK(step_between(end.pose(), begin.pose()) < 1e-12);
  CHECK((end.v - begin.v).norm() < 1e-9);
  CHECK((end.a_W - begin.a_W).norm() < 1e-6);
  CHECK((end.w - begin.w).norm() < 1e-9);
  CHECK((end.w_dot - begin.w_dot).norm() < 1e-6);
}
