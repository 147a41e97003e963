// The state of the recursive spline: adding a control pose, its covariance, the rows of what it measures, its update.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "estimators/spline_state.hpp"
#include "estimators/spline_trajectory.hpp"
#include "plugins/estimators/spline_motion.hpp"

using namespace aslio;
using namespace aslio::test;
using namespace aslio::plugins;
namespace sp = aslio::plugins::spline;

namespace {

const SplineNoise kQuiet{.acceleration = 0, .turn = 0, .kept = 0, .gyro_bias = 0, .acc_bias = 0};

/// Derivative of f(x) by the errors of x, where f gives a vector.
template <class F>
Eigen::MatrixXd numeric_slopes(const SplineState& x, const F& f, double h) {
  const Eigen::VectorXd at = f(x);
  Eigen::MatrixXd out(at.size(), sp::kDim);
  for (int i = 0; i < sp::kDim; ++i) {
    SplineState up = x, down = x;
    up.add(h * sp::Vector::Unit(i), false);
    down.add(-h * sp::Vector::Unit(i), false);
    out.col(i) = (f(up) - f(down)) / (2 * h);
  }
  return out;
}

/// The row of a sum of one row: A = h^T h i, b = h^T z i.
sp::Vector row_of(const SplineInformation& information, double z, double weight) {
  return information.b / (z * weight);
}

}  // namespace

// eq. SPL-5.
TEST_CASE("adding a control pose keeps the motion so far, and goes on evenly") {
  std::mt19937_64 engine(7);
  for (int trial = 0; trial < 10; ++trial) {
    SplineBelief belief{some_spline_state(engine), some_spline_covariance(engine)};
    SplineTrajectory before, after;
    before.begin(belief.x);
    after.begin(belief.x);
    const TimeNs begin = belief.x.begin, end = belief.x.end();
    const SplineMoment at_end = belief.x.moment(end);
    const Mat3 turn = belief.x.control[2].R.transpose() * belief.x.control[3].R;
    const Vec3 step = belief.x.control[3].p - belief.x.control[2].p;
    belief.extend(kQuiet);
    after.follow(belief.x);
    for (int k = 0; k <= 8; ++k) {
      const TimeNs t = begin + k * (end - begin) / 8;
      REQUIRE((before.pose(t).p - after.pose(t).p).norm() < 1e-12);
      REQUIRE((before.pose(t).R - after.pose(t).R).norm() < 1e-12);
    }
    CHECK(belief.x.begin == end);
    CHECK((belief.x.moment(end).v - at_end.v).norm() < 1e-9);
    CHECK((belief.x.moment(end).w - at_end.w).norm() < 1e-9);
    CHECK((belief.x.moment(end).a_W - at_end.a_W).norm() < 1e-6);
    CHECK((belief.x.control[3].p - belief.x.control[2].p - step).norm() < 1e-12);
    CHECK((belief.x.control[2].R.transpose() * belief.x.control[3].R - turn).norm() < 1e-12);
  }
}

// eq. SPL-5.
TEST_CASE("the covariance follows a new control pose by the derivative of the step, with the noise") {
  std::mt19937_64 engine(11);
  for (int trial = 0; trial < 10; ++trial) {
    const SplineBelief before{some_spline_state(engine), some_spline_covariance(engine)};
    SplineBelief carried = before;
    carried.extend(kQuiet);
    const auto extended = [&](const SplineState& x) -> Eigen::VectorXd {
      SplineBelief other{x, sp::Matrix::Zero()};
      other.extend(kQuiet);
      return other.x.minus(carried.x);
    };
    const Eigen::MatrixXd F = numeric_slopes(before.x, extended, 1e-6);
    const sp::Matrix expected = F * before.P * F.transpose();
    CHECK((carried.P - expected).norm() < 1e-7 * expected.norm());
    SplineNoise noise{.acceleration = 3, .turn = 2, .kept = 0.25, .gyro_bias = 1e-3, .acc_bias = 2e-3};
    SplineBelief noisy = before;
    noisy.extend(noise);
    const sp::Vector added = (noisy.P - carried.P).diagonal();
    CHECK((noisy.P - carried.P - sp::Matrix(added.asDiagonal())).norm() < 1e-12);
    constexpr double dt4 = 0.02 * 0.02 * 0.02 * 0.02;
    CHECK(added[sp::p(3)] == Approx(9 * dt4));
    CHECK(added[sp::theta(3)] == Approx(4 * dt4));
    CHECK(added[sp::p(1)] == Approx(0.25 * 9 * dt4));
    CHECK(added[sp::theta(0)] == Approx(0.25 * 4 * dt4));
    CHECK(added[sp::b_w] == Approx(1e-3 * 0.02));
    CHECK(added[sp::b_a] == Approx(2e-3 * 0.02));
    CHECK(added[sp::g] == Approx(0).margin(1e-15));
  }
}

// eq. SPL-7.
TEST_CASE("the rows of points, gyro and accelerometer agree with central differences of the state") {
  std::mt19937_64 engine(13);
  for (int trial = 0; trial < 10; ++trial) {
    const SplineState x = some_spline_state(engine);
    const TimeNs t = x.begin + (1 + trial) * x.interval / 12;
    const SplineMoment at = x.moment(t);
    const SplineSlopes slopes = x.segment().slopes(x.share(t));
    const Vec3 p_I = some_vector(engine, 20), u = some_vector(engine, 1).normalized();
    const auto point = [&](const SplineState& s) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, u.dot(s.moment(t).pose() * p_I));
    };
    SplineInformation information;
    const Vec6 seen = information.add_point(slopes, at.R, p_I, u, 0.5, 4.0);
    CHECK((row_of(information, 0.5, 4.0) - numeric_slopes(x, point, 1e-6).row(0).transpose()).norm() < 1e-6);
    CHECK((information.A - 4.0 * row_of(information, 0.5, 4.0) * row_of(information, 0.5, 4.0).transpose()).norm() <
          1e-9 * information.A.norm());
    CHECK((seen.tail<3>() - u).norm() == 0);
    CHECK(information.weighted_sum == Approx(1.0));

    const ImuSample sample{t, some_vector(engine, 3), some_vector(engine, 10)};
    const auto gyro = [&](const SplineState& s) -> Eigen::VectorXd { return s.moment(t).w + s.b_w - sample.gyro; };
    const auto acc = [&](const SplineState& s) -> Eigen::VectorXd {
      const SplineMoment m = s.moment(t);
      return m.R.transpose() * (m.a_W - s.g) + s.b_a - sample.acc;
    };
    for (int axis = 0; axis < 3; ++axis) {
      SplineInformation of_gyro, of_acc;
      of_gyro.add_gyro(at, slopes, x, sample, 1U << axis, 0.5);
      of_acc.add_acc(at, slopes, x, sample, 1U << axis, 0.25);
      REQUIRE(of_gyro.rows == 1);
      const double z_gyro = gyro(x)[axis], z_acc = acc(x)[axis];
      CHECK(of_gyro.weighted_sum == Approx(z_gyro * z_gyro / 0.5));
      const sp::Vector h_gyro = row_of(of_gyro, z_gyro, 2.0), h_acc = row_of(of_acc, z_acc, 4.0);
      CHECK((h_gyro - numeric_slopes(x, gyro, 1e-6).row(axis).transpose()).norm() < 1e-5 * h_gyro.norm());
      CHECK((h_acc - numeric_slopes(x, acc, 1e-6).row(axis).transpose()).norm() < 1e-5 * h_acc.norm());
    }
    SplineInformation none;
    none.add_gyro(at, slopes, x, sample, 0, 0.5);
    none.add_acc(at, slopes, x, sample, 0, 0.5);
    CHECK(none.rows == 0);
    CHECK(none.A.isZero());
  }
}

// eq. SPL-8.
TEST_CASE("a step of the spline's filter is the textbook's, also with states that are not estimated") {
  std::mt19937_64 engine(17);
  for (int trial = 0; trial < 10; ++trial) {
    sp::Matrix P = some_spline_covariance(engine);
    if (trial % 2 == 1) {
      P.bottomRows<9>().setZero();
      P.rightCols<9>().setZero();
    }
    const SplineState x = some_spline_state(engine);
    SplineInformation information;
    constexpr int n = 12;
    Eigen::Matrix<double, n, sp::kDim> H;
    Eigen::Matrix<double, n, 1> z;
    for (int i = 0; i < n; ++i) {
      SplineInformation one;
      const TimeNs t = x.begin + (i + 1) * x.interval / 13;
      const Vec3 p_I = some_vector(engine, 10), u = some_vector(engine, 1).normalized();
      z[i] = 0.1 + 0.01 * i;
      for (SplineInformation* to : {&one, &information}) {
        to->add_point(x.segment().slopes(x.share(t)), x.moment(t).R, p_I, u, z[i], 100);
      }
      H.row(i) = row_of(one, z[i], 100);
    }
    const Eigen::Matrix<double, n, n> S = H * P * H.transpose() + 0.01 * Eigen::Matrix<double, n, n>::Identity();
    const Eigen::Matrix<double, sp::kDim, n> K = P * H.transpose() * S.inverse();
    const SplineStep step(P, sp::Vector::Zero(), information);
    CHECK((step.delta + K * z).norm() < 1e-8);
    CHECK((step.P - (P - K * H * P)).norm() < 1e-8 * P.norm());
    CHECK(step.P == step.P.transpose());
    CHECK(squared_innovation(P, information) == Approx(z.dot(S.inverse() * z)));
    // An iterate away from the prior comes back to it where nothing is measured.
    sp::Vector d = 1e-3 * sp::Vector::Ones();
    CHECK((SplineStep(P, d, {}).delta + d).norm() < 1e-12);
  }
}

// eq. SPL-6.
TEST_CASE("a motion of constant velocity and rate lies on its spline, with the covariance of its moment") {
  std::mt19937_64 engine(19);
  SplineBelief belief{some_spline_state(engine)};
  const Pose at{exp_so3(some_vector(engine, 2)), some_vector(engine, 5)};
  const Vec3 v = some_vector(engine, 3), w = some_vector(engine, 2);
  const TimeNs t = belief.x.begin;
  belief.x.set(t, at, v, w);
  for (const double s : {0.0, 0.007, 0.02}) {
    const SplineMoment moment = belief.x.moment(t + to_ns(s));
    CHECK((moment.p - at.p - s * v).norm() < 1e-12);
    CHECK((moment.R - at.R * exp_so3(s * w)).norm() < 1e-12);
    CHECK((moment.v - v).norm() < 1e-9);
    CHECK((moment.w - w).norm() < 1e-9);
    CHECK(moment.a_W.norm() + moment.w_dot.norm() < 1e-7);
  }
  sp::MomentMatrix P;
  for (Eigen::Index i = 0; i < P.size(); i += 3) P.reshaped().segment<3>(i) = some_vector(engine, 0.1);
  P = (P * P.transpose()).eval();
  belief.spread(t, P, kQuiet);
  CHECK((belief.moment_covariance(t) - P).norm() < 1e-9 * P.norm());
  const StateMatrix nav = belief.nav_covariance(t);
  CHECK((nav.block<6, 6>(0, 0) - P.block<6, 6>(0, 0)).norm() < 1e-9);
  CHECK((nav.block<3, 3>(block::v, block::b_a) - P.block<3, 3>(sp::moment::v, sp::moment::b_a)).norm() < 1e-9);

  belief.x.change_velocity(t, Vec3(1, 2, 3));
  CHECK((belief.x.moment(t).p - at.p).norm() < 1e-12);
  CHECK((belief.x.moment(t).v - v - Vec3(1, 2, 3)).norm() < 1e-9);
}

// eq. SPL-6.
TEST_CASE("a long gap is passed in one step, with as much doubt as one control pose after the other") {
  std::mt19937_64 engine(23);
  const SplineNoise noise{.acceleration = 2, .turn = 0.01, .gyro_bias = 1e-6, .acc_bias = 1e-5};
  SplineBelief chain{some_spline_state(engine)};
  chain.x.set(chain.x.begin, chain.x.control[0], Vec3(1, -0.5, 0.2), Vec3(0, 0, 0.005));
  chain.spread(chain.x.begin, 1e-6 * sp::MomentMatrix::Identity(), noise);
  SplineBelief jump = chain;
  const TimeNs t = chain.x.begin + 30 * kSecond;
  jump.advance(t, noise);
  REQUIRE(jump.x.begin == t);
  while (t > chain.x.end()) chain.extend(noise);
  CHECK((jump.x.moment(t).p - chain.x.moment(t).p).norm() < 1e-6);
  CHECK(log_so3(jump.x.moment(t).R.transpose() * chain.x.moment(t).R).norm() < 1e-6);
  const StateMatrix P = jump.nav_covariance(t), expected = chain.nav_covariance(t);
  for (int i = 0; i < 15; ++i) {
    CAPTURE(i);
    CHECK(P(i, i) == Approx(expected(i, i)).epsilon(0.03));
  }
  // However long, in finite time and numbers.
  jump.advance(t + 1'000'000 * kSecond, noise);
  CHECK(jump.x.finite());
  CHECK(jump.P.allFinite());
}

// eq. SPL-9.
TEST_CASE("the Jacobian of a spline's trajectory agrees with central differences, and its end moves as one body") {
  std::mt19937_64 engine(29);
  SplineBelief belief{some_spline_state(engine)};
  SplineTrajectory trajectory;
  trajectory.begin(belief.x);
  const TimeNs begin = belief.x.begin;
  for (int k = 0; k < 3; ++k) {
    belief.extend(kQuiet);
    belief.x.add(some_vector(engine, 0.1).x() * sp::Vector::Ones(), false);
    trajectory.follow(belief.x);
  }
  const TimeNs end = belief.x.begin + belief.x.interval / 3;
  trajectory.close(end);
  REQUIRE(trajectory.dof() == 6 * 4);
  for (const TimeNs t : {begin, begin + (end - begin) / 5, begin + (end - begin) / 2, end}) {
    Eigen::MatrixXd jacobian;
    trajectory.jacobian(t, jacobian);
    const Pose here = trajectory.pose(t);
    constexpr double h = 1e-6;
    for (int i = 0; i < trajectory.dof(); ++i) {
      const Eigen::VectorXd xi = h * Eigen::VectorXd::Unit(trajectory.dof(), i);
      const Pose up = trajectory.moved(t, xi), down = trajectory.moved(t, -xi);
      Vec6 slope;
      slope << log_so3(here.R.transpose() * up.R) - log_so3(here.R.transpose() * down.R), up.p - down.p;
      REQUIRE((jacobian.col(i) - slope / (2 * h)).norm() < 1e-7);
    }
  }
  Eigen::MatrixXd at_end;
  trajectory.jacobian(end, at_end);
  CHECK((at_end.rightCols<6>() - Mat6::Identity()).norm() < 1e-12);
  trajectory.straighten(Vec3(1, 2, 3));
  CHECK((trajectory.pose(end).p - trajectory.pose(begin).p - to_seconds(end - begin) * Vec3(1, 2, 3)).norm() < 1e-9);
}
