// Every registered motion model: Jacobians against central differences, propagation against an analytic trajectory.
#include <spdlog/sinks/null_sink.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "aslio/stages/motion.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

using namespace aslio;

namespace {

struct Fixture {
  exec::Executor exec{1};
  SensorModel sensor;
  std::shared_ptr<spdlog::logger> log =
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::null_sink_st>());
  BuildContext context{exec, sensor, log, 0};
  const plugin::Catalog catalog = test::stages_under_test();

  std::unique_ptr<MotionModel> make(const std::string& text) const {
    return test::make_stage<MotionModel>(catalog, text, context);
  }
  std::vector<std::string> all() const { return test::under_test(catalog, MotionModel::family); }
};

NavState tilted_state() {
  NavState s;
  s.R = exp_so3(Vec3(0.3, -0.8, 1.4));
  s.p = Vec3(1, -2, 3);
  s.v = Vec3(0.5, 1.5, -0.2);
  s.b_w = Vec3(0.01, -0.02, 0.03);
  s.b_a = Vec3(-0.1, 0.2, 0.05);
  s.g = Vec3(0.2, -0.1, -9.8);
  s.S_w << 0.01, -0.004, 0.003, 0.002, -0.008, 0.005, -0.001, 0.004, 0.006;
  s.imu_delay = 0.002;
  return s;
}

const ImuSample kFrom{0, Vec3(1.1, -2.0, 3.0), Vec3(3.0, -1.0, 9.0)};
const ImuSample kTo{5'000'000, Vec3(1.3, -1.8, 3.2), Vec3(2.5, -0.5, 10.0)};

NavState plus(const NavState& x, const StateVector& d) {
  NavState y = x;
  y.R = x.R * exp_so3(d.segment<3>(block::theta));
  y.p += d.segment<3>(block::p);
  y.v += d.segment<3>(block::v);
  y.b_w += d.segment<3>(block::b_w);
  y.b_a += d.segment<3>(block::b_a);
  y.g += d.segment<3>(block::g);
  y.S_w += d.segment<9>(block::s).reshaped(3, 3);
  y.imu_delay += d[block::d];
  return y;
}

StateVector minus(const NavState& a, const NavState& b) {
  StateVector d;
  d << log_so3(b.R.transpose() * a.R), a.p - b.p, a.v - b.v, a.b_w - b.b_w, a.b_a - b.b_a, a.g - b.g,
      (a.S_w - b.S_w).reshaped(), a.imu_delay - b.imu_delay;
  return d;
}

}  // namespace

TEST_CASE("every motion model: transition and noise Jacobians agree with central differences") {
  const Fixture f;  // eqs. MOT-2, MOT-4, MOT-6
  for (const std::string& type : f.all()) {
    INFO(type);
    const auto motion = f.make(type);
    const NavState x = tilted_state();
    StateMatrix F;
    Eigen::Matrix<double, kStateDim, 12> G;
    motion->linearise(x, kFrom, kTo, F, G);
    const double h = 1e-5;
    for (int i = 0; i < kStateDim; ++i) {
      StateVector d = StateVector::Zero();
      d[i] = h;
      NavState up = plus(x, d);
      NavState down = plus(x, -d);
      motion->step(up, kFrom, kTo);
      motion->step(down, kFrom, kTo);
      const StateVector column = minus(up, down) / (2 * h);
      CHECK((column - F.col(i)).cwiseAbs().maxCoeff() < 2e-8);
    }
    for (int i = 0; i < 6;
         ++i) {  // a noise on both samples shifts their mean: n_w (0..2), n_a (3..5), measured = true + n
      const auto noisy = [&](double n) {
        ImuSample from = kFrom;
        ImuSample to = kTo;
        (i < 3 ? from.gyro[i] : from.acc[i - 3]) -= n;
        (i < 3 ? to.gyro[i] : to.acc[i - 3]) -= n;
        NavState s = x;
        motion->step(s, from, to);
        return s;
      };
      const StateVector column = minus(noisy(h), noisy(-h)) / (2 * h);
      // G leaves out that the noise of the gyro, too, passes through I - S_w: one part in a hundred of its size.
      const Vec3 through = (Mat3::Identity() - x.S_w).col(i % 3);
      const StateVector expected = i < 3 ? StateVector(G.leftCols<3>() * through) : StateVector(G.col(i));
      CHECK((column - expected).cwiseAbs().maxCoeff() < 2e-8);
    }
  }
}

TEST_CASE("every motion model: covariance propagation equals the dense F P F^T + G Q G^T") {
  const Fixture f;
  StateMatrix A = StateMatrix::Zero();
  for (int i = 0; i < kStateDim; ++i) {
    for (int j = 0; j < kStateDim; ++j) A(i, j) = std::sin(1.7 * i + 0.9 * j + 0.3 * i * j);
  }
  const StateMatrix P = A * A.transpose();
  ImuNoise noise{1e-2, 2e-1, 3e-3, 4e-3};
  const bool uneven = GENERATE(false, true);  // eq. MOT-12
  if (uneven) {
    noise.gyro_axes = Vec3(0, 3, 0.5);
    noise.acc_axes = Vec3(2, 0, 0);
  }
  Eigen::Matrix<double, 12, 1> q;
  q << Vec3::Constant(noise.gyro) + noise.gyro_axes, Vec3::Constant(noise.acc) + noise.acc_axes,
      Vec3::Constant(noise.gyro_bias), Vec3::Constant(noise.acc_bias);
  for (const std::string& type : f.all()) {
    INFO(type);
    const auto motion = f.make(type);
    StateMatrix F;
    Eigen::Matrix<double, kStateDim, 12> G;
    motion->linearise(tilted_state(), kFrom, kTo, F, G);
    const StateMatrix expected = F * P * F.transpose() + G * q.asDiagonal() * G.transpose();
    StateMatrix actual = P;
    motion->propagate_covariance(tilted_state(), kFrom, kTo, noise, actual);
    CHECK((actual - expected).cwiseAbs().maxCoeff() < 1e-10 * expected.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("every motion model: a segment starts at the state before and moves with it") {
  const Fixture f;
  for (const std::string& type : f.all()) {
    INFO(type);
    NavState s = tilted_state();
    const NavState before = s;
    const MotionSegment segment = f.make(type)->step(s, kFrom, kTo);
    CHECK((segment.pose(kFrom.t).R - before.R).norm() < 1e-14);
    CHECK((segment.pose(kFrom.t).p - before.p).norm() < 1e-14);
    CHECK((segment.pose(kTo.t).R - s.R).norm() < 1e-12);
    CHECK((segment.pose(kTo.t).p - s.p).norm() < 2e-4);  // Euler drops the dt^2 term: a dt^2 / 2 = 1.3e-4 m
    CHECK(s.t == kTo.t);
    CHECK((s.R.transpose() * s.R - Mat3::Identity()).norm() < 1e-14);
  }
}

namespace {

/// A circle walked at constant speed while turning with it and nodding: position and attitude in closed form.
struct Analytic {
  double rate = 2.0, radius = 1.5, nod = 0.4, nod_rate = 3.0;

  Mat3 R(double t) const { return exp_so3(Vec3(0, 0, rate * t)) * exp_so3(Vec3(0, nod * std::sin(nod_rate * t), 0)); }
  Vec3 p(double t) const { return radius * Vec3(std::cos(rate * t), std::sin(rate * t), 0); }
  Vec3 v(double t) const { return radius * rate * Vec3(-std::sin(rate * t), std::cos(rate * t), 0); }
  Vec3 a(double t) const { return -rate * rate * p(t); }
  Vec3 w(double t) const {  // body rate of Rz(rate t) Ry(nod sin): Ry^T e_z rate + e_y nod'
    const Mat3 Ry = exp_so3(Vec3(0, nod * std::sin(nod_rate * t), 0));
    return Ry.transpose() * Vec3(0, 0, rate) + Vec3(0, nod * nod_rate * std::cos(nod_rate * t), 0);
  }
  ImuSample sample(double t, const Vec3& g) const { return {to_ns(t), w(t), R(t).transpose() * (a(t) - g)}; }
};

double position_error_after(const MotionModel& motion, double seconds, int samples_per_second) {
  const Analytic truth;
  NavState s;
  s.R = truth.R(0);
  s.p = truth.p(0);
  s.v = truth.v(0);
  ImuSample from = truth.sample(0, s.g);
  const int steps = static_cast<int>(seconds * samples_per_second);
  for (int i = 1; i <= steps; ++i) {
    const ImuSample to = truth.sample(static_cast<double>(i) / samples_per_second, s.g);
    motion.step(s, from, to);
    from = to;
  }
  return (s.p - truth.p(seconds)).norm();
}

}  // namespace

TEST_CASE("midpoint integration of an analytic trajectory converges with the square of the step, Euler with the step") {
  const Fixture f;  // eqs. MOT-1, MOT-4
  const auto midpoint = f.make("imu_midpoint");
  const double coarse = position_error_after(*midpoint, 10.0, 200);
  const double fine = position_error_after(*midpoint, 10.0, 2000);
  CHECK(coarse < 0.02);
  CHECK(coarse / fine > 80);
  CHECK(coarse / fine < 125);
  const auto euler = f.make("imu_euler");
  const double euler_coarse = position_error_after(*euler, 10.0, 200);
  CHECK(euler_coarse > 3 * coarse);
  const double ratio = euler_coarse / position_error_after(*euler, 10.0, 2000);
  CHECK(ratio > 8);
  CHECK(ratio < 12.5);
}

namespace {

/// Greatest angle between the attitude that a segment says inside its interval and the true one [rad], over a motion
/// that starts every interval at the true attitude.
double attitude_error_inside(const MotionModel& motion, int samples_per_second) {
  const Analytic truth{.nod = 0.3, .nod_rate = 12.0};
  const double dt = 1.0 / samples_per_second;
  double worst = 0;
  for (int i = 0; i < samples_per_second; ++i) {
    NavState s;
    s.R = truth.R(i * dt);
    const MotionSegment segment = motion.step(s, truth.sample(i * dt, s.g), truth.sample((i + 1) * dt, s.g));
    for (const double share : {0.25, 0.5, 0.75}) {
      const double t = (i + share) * dt;
      worst = std::max(worst, log_so3(truth.R(t).transpose() * segment.pose(to_ns(t)).R).norm());
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("between two samples a linear rate is right to the third order of the step, a constant one to the second") {
  const Fixture f;  // eq. MOT-10
  const auto constant = f.make("imu_midpoint"), linear = f.make("{type: imu_midpoint, rate: linear}");
  // At most the nod's angular acceleration, 43 rad/s^2, times dt^2 / 8.
  CHECK(attitude_error_inside(*constant, 200) > 1e-4);
  CHECK(attitude_error_inside(*constant, 200) < 1.4e-4);
  CHECK(attitude_error_inside(*linear, 200) < 0.1 * attitude_error_inside(*constant, 200));
  CHECK(attitude_error_inside(*constant, 100) / attitude_error_inside(*constant, 200) == Approx(4).margin(0.5));
  CHECK(attitude_error_inside(*linear, 100) / attitude_error_inside(*linear, 200) == Approx(8).margin(2));
}

TEST_CASE("a linear rate changes nothing at the ends of the steps, and is read with the sensitivity of the gyro") {
  const Fixture f;  // eq. MOT-10
  NavState a = tilted_state(), b = tilted_state();
  const MotionSegment constant = f.make("imu_midpoint")->step(a, kFrom, kTo);
  const MotionSegment linear = f.make("{type: imu_midpoint, rate: linear}")->step(b, kFrom, kTo);
  CHECK(minus(a, b).norm() == 0.0);
  CHECK((linear.pose(kTo.t).R - constant.pose(kTo.t).R).norm() < 1e-15);
  CHECK((linear.pose(kFrom.t).R - constant.pose(kFrom.t).R).norm() < 1e-15);
  CHECK((linear.pose(kTo.t / 2).R - constant.pose(kTo.t / 2).R).norm() > 1e-4);
  CHECK(constant.w_dot == Vec3::Zero());
  const Vec3 change = (kTo.gyro - kFrom.gyro) / 0.005;
  CHECK((linear.w_dot - (change - tilted_state().S_w * change)).norm() < 1e-9);
}
