#include "motions/imu_euler.hpp"

#include "motions/imu_transition.hpp"

namespace aslio::plugins {

namespace {

ImuTransition transition(const NavState& before, const ImuSample& from, const ImuSample& to) {
  const double dt = to_seconds(to.t - from.t);
  const Vec3 turn = dt * (0.5 * (from.gyro + to.gyro) - before.b_w);
  const Vec3 a = 0.5 * (from.acc + to.acc) - before.b_a;
  ImuTransition f;
  f.dt = dt;
  f.position_factor = 0.0;
  f.theta_theta = exp_so3(-turn);
  f.theta_bw = -dt * right_jacobian_so3(turn);
  f.v_theta = -dt * before.R * hat(a);
  f.v_bw = Mat3::Zero();
  f.v_ba = -dt * before.R;
  return f;
}

}  // namespace

void ImuEuler::describe(config::Binder& b, Params& p) {
  (void)b;
  (void)p;
}

ImuEuler::ImuEuler(const Params& params, const BuildContext& context) {
  (void)params;
  (void)context;
}

MotionSegment ImuEuler::step(NavState& state, const ImuSample& from, const ImuSample& to) const {
  const double dt = to_seconds(to.t - from.t);
  const Vec3 w = 0.5 * (from.gyro + to.gyro) - state.b_w;
  const Vec3 a_W = state.R * (0.5 * (from.acc + to.acc) - state.b_a) + state.g;  // eq. MOT-4
  const MotionSegment segment{from.t, dt, state.R, state.p, state.v, w, a_W};
  state.R = orthonormalised(state.R * exp_so3(dt * w));
  state.p += dt * state.v;
  state.v += dt * a_W;
  state.t = to.t;
  return segment;
}

void ImuEuler::propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to,
                                    const ImuNoise& noise, StateMatrix& P) const {
  transition(before, from, to).apply(noise, P);
}

void ImuEuler::linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                         Eigen::Matrix<double, kStateDim, 12>& G) const {
  transition(before, from, to).dense(F, G);
}

}  // namespace aslio::plugins
