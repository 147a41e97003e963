#include "my_stage.hpp"

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

namespace {

/// What an interval is moved by: the later sample without bias, sensitivity error and delay.
struct Input {
  Input(const NavState& state, const ImuSample& from, const ImuSample& to)
      : dt(to_seconds(to.t - from.t)),
        w_measured(to.gyro),
        w_change(dt > 0 ? Vec3((to.gyro - from.gyro) / dt) : Vec3::Zero()),
        a_change(dt > 0 ? Vec3((to.acc - from.acc) / dt) : Vec3::Zero()),
        w(w_measured - state.b_w - state.S_w * w_measured + state.imu_delay * w_change),
        a(to.acc - state.b_a + state.imu_delay * a_change) {}

  double dt;        ///< [s]
  Vec3 w_measured;  ///< [rad/s]
  Vec3 w_change;    ///< [rad/s^2]
  Vec3 a_change;    ///< [m/s^3]
  Vec3 w, a;        ///< [rad/s], [m/s^2]
};

}  // namespace

void MyStage::describe(config::Binder& b, Params& p) {
  (void)b;
  (void)p;
}

MyStage::MyStage(const Params& params, const BuildContext& context) {
  (void)params;
  (void)context;
}

MotionSegment MyStage::step(NavState& state, const ImuSample& from, const ImuSample& to) const {
  const Input u(state, from, to);
  const Vec3 a_W = state.R * u.a + state.g;
  const MotionSegment segment{from.t, u.dt, state.R, state.p, state.v, u.w, a_W};
  state.R = orthonormalised(state.R * exp_so3(u.dt * u.w));
  state.p += u.dt * state.v + 0.5 * u.dt * u.dt * a_W;
  state.v += u.dt * a_W;
  state.t = to.t;
  return segment;
}

void MyStage::propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to,
                                   const ImuNoise& noise, StateMatrix& P) const {
  StateMatrix F;
  Eigen::Matrix<double, kStateDim, 12> G;
  linearise(before, from, to, F, G);
  Eigen::Matrix<double, 12, 1> q;
  q << Vec3::Constant(noise.gyro) + noise.gyro_axes, Vec3::Constant(noise.acc) + noise.acc_axes,
      Vec3::Constant(noise.gyro_bias), Vec3::Constant(noise.acc_bias);
  const StateMatrix moved = F * P;
  P.noalias() = moved * F.transpose();
  P.noalias() += G * q.asDiagonal() * G.transpose();
}

void MyStage::linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                        Eigen::Matrix<double, kStateDim, 12>& G) const {
  const Input u(before, from, to);
  const Vec3 turn = u.dt * u.w;
  const Mat3 theta_bw = -u.dt * right_jacobian_so3(turn);
  const Mat3 v_ba = -u.dt * before.R;
  F.setIdentity();
  F.block<3, 3>(block::theta, block::theta) = exp_so3(-turn);
  F.block<3, 3>(block::theta, block::b_w) = theta_bw;
  // S_w acts as a bias S_w w_measured of the gyro, the delay as biases of both sensors by their rates of change.
  for (int c = 0; c < 3; ++c) F.block<3, 3>(block::theta, block::s + 3 * c) = u.w_measured[c] * theta_bw;
  F.block<3, 1>(block::theta, block::d) = -theta_bw * u.w_change;
  F.block<3, 3>(block::v, block::theta) = v_ba * hat(u.a);
  F.block<3, 3>(block::v, block::b_a) = v_ba;
  F.block<3, 3>(block::v, block::g) = u.dt * Mat3::Identity();
  F.block<3, 1>(block::v, block::d) = -v_ba * u.a_change;
  // p moves with the mean of the velocities before and after.
  F.middleRows<3>(block::p) += 0.5 * u.dt * F.middleRows<3>(block::v);
  F.block<3, 3>(block::p, block::v) = u.dt * Mat3::Identity();
  G.setZero();
  G.block<3, 3>(block::theta, 0) = theta_bw;
  G.block<3, 3>(block::v, 3) = v_ba;
  G.block<3, 3>(block::p, 3) = 0.5 * u.dt * v_ba;
  G.block<3, 3>(block::b_w, 6) = u.dt * Mat3::Identity();
  G.block<3, 3>(block::b_a, 9) = u.dt * Mat3::Identity();
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<MotionModel>(catalog).add<MyStage>("my_stage", "IMU integration that holds the later sample.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
