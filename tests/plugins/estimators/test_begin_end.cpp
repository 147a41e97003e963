// A path between two unknown poses: the ends, the Jacobians against central differences, the information of the end.
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "aslio/toolkit/begin_end.hpp"

using namespace aslio;

namespace {

constexpr TimeNs kBegin = 5 * kSecond, kEnd = kBegin + kSecond / 10;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine_() >> 11) * 0x1p-53 - 1.0); }
  Vec3 vector(double half) { return {(*this)(half), (*this)(half), (*this)(half)}; }
  Pose pose(double turn) { return {exp_so3(vector(turn)), vector(10)}; }

 private:
  std::mt19937_64 engine_;
};

/// The path after its ends have moved by (theta_b, p_b, theta_e, p_e).
BeginEnd moved(const BeginEnd& path, const Vec12& by) {
  BeginEnd out;
  out.set(kBegin, path.begin().moved(by.head<6>()), kEnd, path.end().moved(by.tail<6>()));
  return out;
}

BeginEnd random_path(Random& random, double turn) {
  const Pose begin = random.pose(2.0);
  BeginEnd path;
  path.set(kBegin, begin, kEnd, {begin.R * exp_so3(random.vector(turn)), begin.p + random.vector(1)});
  return path;
}

}  // namespace

TEST_CASE("begin_end: the path starts and ends where it is told to and turns evenly") {  // eq. CT-1
  Random random(1);
  const BeginEnd path = random_path(random, 1.0);
  for (const auto& [t, pose] : {std::pair{kBegin, path.begin()}, {kEnd, path.end()}}) {
    CHECK((path.pose(t).R - pose.R).norm() < 1e-12);
    CHECK((path.pose(t).p - pose.p).norm() < 1e-12);
  }
  const Pose middle = path.pose((kBegin + kEnd) / 2);
  const Pose expected = interpolate(path.begin(), path.end(), 0.5);
  CHECK((middle.R - expected.R).norm() < 1e-9);
  CHECK((middle.p - expected.p).norm() < 1e-9);
  CHECK(path.share(kBegin - 1) == 0.0);
  CHECK(path.share(kEnd + 1) == 1.0);
}

TEST_CASE("begin_end: the Jacobian agrees with central differences") {  // eq. CT-2
  Random random(2);
  constexpr double h = 1e-6;
  for (const double turn : {1e-6, 0.05, 0.5, 1.5}) {
    const BeginEnd path = random_path(random, turn);
    for (const double share : {0.0, 0.1, 0.5, 0.83, 1.0}) {
      const TimeNs t = kBegin + static_cast<TimeNs>(share * static_cast<double>(kEnd - kBegin));
      Eigen::MatrixXd J;
      path.jacobian(t, J);
      REQUIRE(J.cols() == path.dof());
      const Pose here = path.pose(t);
      for (int i = 0; i < 12; ++i) {
        const Pose plus = moved(path, h * Vec12::Unit(i)).pose(t), minus = moved(path, -h * Vec12::Unit(i)).pose(t);
        Vec6 slope;
        slope << (log_so3(here.R.transpose() * plus.R) - log_so3(here.R.transpose() * minus.R)) / (2 * h),
            (plus.p - minus.p) / (2 * h);
        CAPTURE(turn, share, i);
        CHECK((slope - J.col(i)).norm() < 1e-7);
      }
    }
  }
}

TEST_CASE("begin_end: the row of a point agrees with central differences of its residual") {  // eq. CT-2
  Random random(3);
  constexpr double h = 1e-6;
  for (int trial = 0; trial < 20; ++trial) {
    const BeginEnd path = random_path(random, 1.0);
    const double share = 0.5 + random(0.5);
    const Vec3 p_I = random.vector(20), u = random.vector(1).normalized(), q = random.vector(5);
    const auto residual = [&](const BeginEnd& at) { return u.dot(at.at(share).T * p_I - q); };
    BeginEndInformation sum;
    sum.add(path.at(share), path.at(share).T * p_I, u, residual(path), 4.0);
    Vec12 slope;
    for (int i = 0; i < 12; ++i) {
      slope[i] = (residual(moved(path, h * Vec12::Unit(i))) - residual(moved(path, -h * Vec12::Unit(i)))) / (2 * h);
    }
    CHECK((sum.A - 4.0 * slope * slope.transpose()).norm() < 1e-5 * sum.A.norm());
    CHECK((sum.b - 4.0 * residual(path) * slope).norm() < 1e-5 * (1.0 + sum.b.norm()));
    CHECK(sum.accepted == 1);
  }
}

TEST_CASE("begin_end: what is known of the end is the inverse of its block of the covariance") {  // eq. CT-4
  Random random(4);
  Mat12 A = Mat12::Zero();
  for (int i = 0; i < 40; ++i) {
    Vec12 row;
    for (int j = 0; j < 12; ++j) row[j] = random(1);
    A += row * row.transpose();
  }
  const Mat6 expected = A.inverse().bottomRightCorner<6, 6>().inverse();
  CHECK((end_information(A) - expected).norm() < 1e-6 * expected.norm());
  A.setZero();
  A.bottomRightCorner<6, 6>().setIdentity();  // nothing is known of the begin, and the end does not depend on it
  CHECK((end_information(A) - Mat6::Identity()).norm() < 1e-9);
}
