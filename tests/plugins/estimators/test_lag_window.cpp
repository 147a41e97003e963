// Preintegration against numeric integration, Jacobians of every row against central differences, and the smoothed
// states: against the least squares over all states at once, and in their right order of certainty.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "estimators/lag_window.hpp"
#include "motions/imu_midpoint.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/estimators/smooth_motion.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::ImuMidpoint;

namespace {

struct Random {
  std::mt19937_64 engine{11};
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); }
  Vec3 vector(double half) {
    const double x = (*this)(half), y = (*this)(half), z = (*this)(half);
    return {x, y, z};
  }
  NavState state() {
    NavState s;
    s.R = exp_so3(vector(2.0));
    s.p = vector(20.0);
    s.v = vector(3.0);
    s.b_w = vector(0.05);
    s.b_a = vector(0.3);
    return s;
  }
};

std::vector<ImuSample> samples(double seconds, int count) {
  std::vector<ImuSample> out;
  for (int i = 0; i <= count; ++i) out.push_back(smooth_sample(seconds * i / count));
  return out;
}

/// The state after `seconds` by the classical Runge-Kutta rule over (R, v, p), R as a matrix.
NavState integrated(const NavState& from, double seconds) {
  const int steps = 4000;
  const double h = seconds / steps;
  struct Rate {
    Mat3 R;
    Vec3 v, p;
  };
  const auto rate = [&](double t, const Mat3& R, const Vec3& v) {
    const ImuSample s = smooth_sample(t);
    return Rate{R * hat(s.gyro - from.b_w), R * (s.acc - from.b_a) + from.g, v};
  };
  NavState x = from;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const Rate a = rate(t, x.R, x.v), b = rate(t + h / 2, x.R + h / 2 * a.R, x.v + h / 2 * a.v),
               c = rate(t + h / 2, x.R + h / 2 * b.R, x.v + h / 2 * b.v), d = rate(t + h, x.R + h * c.R, x.v + h * c.v);
    x.R += h / 6 * (a.R + 2 * b.R + 2 * c.R + d.R);
    x.v += h / 6 * (a.v + 2 * b.v + 2 * c.v + d.v);
    x.p += h / 6 * (a.p + 2 * b.p + 2 * c.p + d.p);
  }
  x.R = orthonormalised(x.R);
  return x;
}

/// Largest difference of the Jacobians of a term from central differences, relative to the largest entry.
double jacobian_error(const StateTerm& term, const NavState& i, const NavState& j) {
  const NavState* second = term.two() ? &j : nullptr;
  const StateTerm::At at = term.at(i, second);
  REQUIRE(at.r.size() == term.rows());
  double worst = 0;
  for (int k = 0; k < kNodeDim; ++k) {
    const Vec15 step = 1e-6 * Vec15::Unit(k);
    const StateTerm::Rows of_i = (term.at(moved(i, step), second).r - term.at(moved(i, -step), second).r) / 2e-6;
    worst = std::max(worst, (of_i - at.J_i.col(k)).cwiseAbs().maxCoeff());
    if (!term.two()) continue;
    const NavState more = moved(j, step), less = moved(j, -step);
    const StateTerm::Rows of_j = (term.at(i, &more).r - term.at(i, &less).r) / 2e-6;
    worst = std::max(worst, (of_j - at.J_j.col(k)).cwiseAbs().maxCoeff());
  }
  return worst / std::max(at.J_i.cwiseAbs().maxCoeff(), at.J_j.cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("preintegration leads where numeric integration does, ever nearer with finer samples") {  // eq. PRE-1
  Random random;
  for (int trial = 0; trial < 3; ++trial) {
    const NavState from = random.state(), truth = integrated(from, 0.5);
    double last = 0;
    for (const int count : {50, 100, 200}) {
      const Preintegration m(samples(0.5, count), from, {});
      CHECK(m.seconds == Approx(0.5));
      const NavState to = carried(from, m);
      const double error =
          (to.p - truth.p).norm() + (to.v - truth.v).norm() + log_so3(to.R.transpose() * truth.R).norm();
      if (count > 50) CHECK(error == Approx(last / 4).epsilon(0.1));  // second order
      last = error;
    }
    CHECK(last < 2e-5);
  }
}

TEST_CASE("preintegration reads a gyro with errors of its sensitivity, and an IMU that is late, as the motions do") {
  // eqs. PRE-1, MOT-6
  BuildEnvironment environment;
  const ImuMidpoint motion({}, environment.context());
  Random random;
  for (int trial = 0; trial < 3; ++trial) {
    NavState from = random.state();
    if (trial != 1) from.S_w << random.vector(0.05), random.vector(0.05), random.vector(0.05);
    if (trial != 2) from.imu_delay = random(0.01);
    const auto imu = samples(0.5, 50);
    NavState to = from;
    for (std::size_t i = 1; i < imu.size(); ++i) motion.step(to, imu[i - 1], imu[i]);
    const NavState found = carried(from, Preintegration(imu, from, {}));
    CHECK((found.p - to.p).norm() < 1e-12);  // rounding: 20 m
    CHECK((found.v - to.v).norm() < 1e-13);
    CHECK(log_so3(found.R.transpose() * to.R).norm() < 1e-13);
  }
}

TEST_CASE("preintegration: derivatives for the biases are those of central differences") {  // eq. PRE-2
  Random random;
  const auto imu = samples(0.4, 80);
  const Vec3 b_w = random.vector(0.1), b_a = random.vector(0.5);
  const Preintegration m(imu, biased(b_w, b_a), {});
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = 1e-5 * Vec3::Unit(axis);
    const Preintegration up(imu, biased(b_w + step, b_a), {}), down(imu, biased(b_w - step, b_a), {});
    CHECK((log_so3(m.dR.transpose() * up.dR) / 1e-5 - m.dR_bw.col(axis)).norm() < 1e-5);
    CHECK(((up.dv - down.dv) / 2e-5 - m.dv_bw.col(axis)).norm() < 1e-7);
    CHECK(((up.dp - down.dp) / 2e-5 - m.dp_bw.col(axis)).norm() < 1e-7);
    const Preintegration more(imu, biased(b_w, b_a + step), {}), less(imu, biased(b_w, b_a - step), {});
    CHECK(((more.dv - less.dv) / 2e-5 - m.dv_ba.col(axis)).norm() < 1e-7);
    CHECK(((more.dp - less.dp) / 2e-5 - m.dp_ba.col(axis)).norm() < 1e-7);
  }
}

TEST_CASE("preintegration: the covariance is that of many noisy recordings") {  // eq. PRE-3
  std::mt19937_64 engine(3);
  const auto normal = [&] {  // sum of twelve, good enough for second moments
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(engine() >> 11) * 0x1p-53;
    return sum;
  };
  const auto imu = samples(0.5, 50);
  // Noise of the mean of two samples, as an interval sees it: every interval has its own.
  InertialNoise noise{.gyro = 0.02, .acc = 0.2, .integration = 1e-9};
  const Preintegration truth(imu, NavState{}, noise);
  Preintegration::Mat9 found = Preintegration::Mat9::Zero();
  const int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    // An interval of its own per pair of samples, chained.
    NavState x;
    x.g.setZero();
    for (std::size_t i = 1; i < imu.size(); ++i) {
      const double dt = to_seconds(imu[i].t - imu[i - 1].t);
      const Vec3 n_w = noise.gyro / std::sqrt(dt) * Vec3(normal(), normal(), normal());
      const Vec3 n_a = noise.acc / std::sqrt(dt) * Vec3(normal(), normal(), normal());
      const std::vector<ImuSample> pair{imu[i - 1], imu[i]};
      x = carried(x, Preintegration(pair, biased(n_w, n_a), noise));
    }
    Eigen::Matrix<double, 9, 1> off;
    off << log_so3(truth.dR.transpose() * x.R), x.p - truth.dp, x.v - truth.dv;
    found += off * off.transpose() / runs;
  }
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) {
      const double scale = std::sqrt(truth.covariance(i, i) * truth.covariance(j, j));
      CHECK(found(i, j) / scale == Approx(truth.covariance(i, j) / scale).margin(0.08));
    }
  }
}

TEST_CASE("rows of the smoother: Jacobians are those of central differences") {  // eqs. LAG-1, LAG-2
  Random random;
  for (int trial = 0; trial < 10; ++trial) {
    const NavState i = random.state();
    const NavState known = biased(i.b_w + random.vector(0.01), i.b_a + random.vector(0.05));
    const Preintegration m(samples(0.3, 60), known, {});
    const NavState j = moved(carried(i, m), 0.1 * Vec15::Random());
    InertialTerm inertial(0, m, i.g, {});
    CHECK(jacobian_error(inertial, i, j) < 1e-6);
    PoseTerm pose(0, j.pose(), 0.05, 0.1);
    CHECK(jacobian_error(pose, i, j) < 1e-6);
    const Mat15 U = Mat15::Random();
    PriorTerm prior(0, j, U, Vec15::Random());
    CHECK(jacobian_error(prior, i, j) < 1e-6);
  }
}

namespace {

/// A walk with known poses, seen by a biased IMU.
struct Walk {
  NavState truth;  ///< at the start
  std::vector<Preintegration> motions;
  std::vector<NavState> states;
  explicit Walk(int windows) {
    truth.v = Vec3(1.0, 0.2, 0.0);
    states.push_back(truth);
    for (int k = 0; k < windows; ++k) {
      std::vector<ImuSample> imu;
      for (int i = 0; i <= 20; ++i) imu.push_back(smooth_sample(0.1 * k + 0.005 * i));
      const NavState next = carried(states.back(), Preintegration(imu, NavState{}, {}));
      states.push_back(next);
      for (ImuSample& s : imu) {
        s.gyro += Vec3(0.01, -0.02, 0.015);
        s.acc += Vec3(0.1, -0.05, 0.08);
      }
      motions.emplace_back(imu, NavState{}, InertialNoise{});
    }
  }
};

}  // namespace

TEST_CASE("the smoother learns velocity and biases from poses, and says how well it knows them") {  // eq. LAG-4
  const Walk walk(100);
  LagWindow::Params params;
  params.sigma_rotation = 1e-3;
  params.sigma_position = 1e-3;
  LagWindow window(params);
  NavState start = walk.truth;
  start.v.setZero();
  window.start(start, start_sigma());
  for (std::size_t k = 0; k < walk.motions.size(); ++k) {
    window.append(walk.motions[k], carried(window.newest(), walk.motions[k]));
    window.measure(walk.states[k + 1].pose(), false);
    REQUIRE(window.solve());
    CHECK(window.size() <= 20);
  }
  const NavState& found = window.newest();
  CHECK((found.p - walk.states.back().p).norm() < 2e-3);
  CHECK((found.v - walk.states.back().v).norm() < 0.02);
  CHECK((found.b_w - Vec3(0.01, -0.02, 0.015)).norm() < 2e-3);
  CHECK((found.b_a - Vec3(0.1, -0.05, 0.08)).norm() < 0.02);
  const Vec15 off = plugins::difference(found, walk.states.back());
  Vec15 expected = off;
  expected.segment<3>(9) -= Vec3(0.01, -0.02, 0.015);
  expected.segment<3>(12) -= Vec3(0.1, -0.05, 0.08);
  CHECK(expected.dot(window.covariance().ldlt().solve(expected)) < 40.0);  // 15 unknowns
}

TEST_CASE("what has left the lag counts on: the newest state is that of all states at once") {  // eq. LAG-3
  const Walk walk(12);
  LagWindow::Params one;
  one.lag = 1000;
  LagWindow::Params few = one;
  few.lag = 3;
  LagWindow all(one), lagged(few);
  NavState start = walk.truth;
  start.v += Vec3(0.05, 0, 0);
  for (LagWindow* window : {&all, &lagged}) {
    window->start(start, start_sigma());
    for (std::size_t k = 0; k < walk.motions.size(); ++k) {
      window->append(walk.motions[k], carried(window->newest(), walk.motions[k]));
      if (k % 3 != 1) window->measure(walk.states[k + 1].pose(), k % 4 == 0);
      REQUIRE(window->solve());
    }
  }
  CHECK(all.size() == 13);
  CHECK(lagged.size() == 3);
  // But for the points at which what left was linearised.
  const Vec15 off = plugins::difference(lagged.newest(), all.newest());
  const Vec15 sigma = all.covariance().diagonal().cwiseSqrt();
  CHECK((off.array() / sigma.array()).abs().maxCoeff() < 0.05);
  for (int i = 0; i < kNodeDim; ++i) {
    CHECK(std::sqrt(lagged.covariance()(i, i)) == Approx(sigma[i]).epsilon(0.02));
  }
}

TEST_CASE("tilt and heading of a start are those of the world, however the sensor is mounted") {  // eq. LAG-5
  NavState start;
  start.g = Vec3(0, 0, -9.81);
  start.R = exp_so3(Vec3(0, 1.5, 0)) * exp_so3(Vec3(0.3, 0, 0));  // its x points down, nearly
  Vec15 sigma = start_sigma();
  sigma.head<3>() = Vec3(0.05, 0.05, 0.001);
  LagWindow window(LagWindow::Params{});
  window.start(start, sigma);
  const auto in_world = [&] { return Mat3(start.R * window.covariance().topLeftCorner<3, 3>() * start.R.transpose()); };
  const Mat3 expected = Vec3(0.0025, 0.0025, 1e-6).asDiagonal();
  CHECK((in_world() - expected).norm() < 1e-12);
  REQUIRE(window.solve());  // and so say the rows
  CHECK((in_world() - expected).norm() < 1e-9);
}

TEST_CASE("a registration that left a direction open hardly counts") {
  const Walk walk(1);
  Vec3 found[2];
  for (const bool degenerate : {false, true}) {
    LagWindow window(LagWindow::Params{});
    window.start(walk.truth, start_sigma());
    window.append(walk.motions[0], carried(walk.truth, walk.motions[0]));
    const Vec3 alone = window.newest().p;
    window.measure({window.newest().R, alone + Vec3(0.1, 0, 0)}, degenerate);
    REQUIRE(window.solve());
    found[degenerate ? 1 : 0] = window.newest().p - alone;
  }
  CHECK(found[0].x() > 10 * found[1].x());
  CHECK(found[1].x() > 0);
}

TEST_CASE("the smoother gives the same bits for the same input") {
  const Walk walk(30);
  Vec15 first = Vec15::Zero();
  for (int run = 0; run < 2; ++run) {
    LagWindow window(LagWindow::Params{});
    window.start(walk.truth, start_sigma());
    for (std::size_t k = 0; k < walk.motions.size(); ++k) {
      window.append(walk.motions[k], carried(window.newest(), walk.motions[k]));
      window.measure(walk.states[k + 1].pose(), false);
      REQUIRE(window.solve());
    }
    const Vec15 here = plugins::difference(window.newest(), walk.truth);
    if (run == 0) first = here;
    CHECK(here == first);
  }
}
