#include "motions/imu_euler.hpp"

#include "motions/imu_transition.hpp"

namespace aslio::plugins {

namespace {

ImuTransition euler_transition(const NavState& before, const ImuSample& from, const ImuSample& to) {
  const ImuMean u(before, from, to);
  const double dt = u.dt;
  const Vec3 turn = dt * u.w;
  ImuTransition f(u);
  f.position_factor = 0.0;
  f.theta_theta = exp_so3(-turn);
  f.theta_bw = -dt * right_jacobian_so3(turn);
  f.v_theta = -dt * before.R * hat(u.a);
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
  const ImuMean u(state, from, to);
  const Vec3 a_W = state.R * u.a + state.g;  // eq. MOT-4
  const MotionSegment segment{from.t, u.dt, state.R, state.p, state.v, u.w, a_W};
  state.R = orthonormalised(state.R * exp_so3(u.dt * u.w));
  state.p += u.dt * state.v;
  state.v += u.dt * a_W;
  state.t = to.t;
  return segment;
}

void ImuEuler::propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to,
                                    const ImuNoise& noise, StateMatrix& P) const {
  euler_transition(before, from, to).apply(noise, P);
}

void ImuEuler::linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                         Eigen::Matrix<double, kStateDim, 12>& G) const {
  euler_transition(before, from, to).dense(F, G);
}

}  // namespace aslio::plugins
