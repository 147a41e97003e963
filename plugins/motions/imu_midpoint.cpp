#include "motions/imu_midpoint.hpp"

#include "motions/imu_transition.hpp"

namespace aslio::plugins {

namespace {

ImuTransition midpoint_transition(const NavState& before, const ImuSample& from, const ImuSample& to) {
  const ImuMean u(before, from, to);
  const Vec3 half_turn = 0.5 * u.dt * u.w;
  const Mat3 R_mid = before.R * exp_so3(half_turn);
  ImuTransition f(u);
  f.position_factor = 0.5 * u.dt;
  f.theta_theta = exp_so3(-u.dt * u.w);
  f.theta_bw = -u.dt * right_jacobian_so3(u.dt * u.w);
  f.v_theta = -u.dt * before.R * hat(exp_so3(half_turn) * u.a);
  f.v_bw = 0.5 * u.dt * u.dt * R_mid * hat(u.a) * right_jacobian_so3(half_turn);
  f.v_ba = -u.dt * R_mid;
  return f;
}

}  // namespace

void ImuMidpoint::describe(config::Binder& b, Params& p) {
  b.choice("rate", p.rate, {{"constant", Rate::constant}, {"linear", Rate::linear}},
           "turn rate between two samples: their mean throughout, or linear from one to the other; only points "
           "measured between them differ");
}

ImuMidpoint::ImuMidpoint(const Params& params, const BuildContext& context) : rate_(params.rate) { (void)context; }

MotionSegment ImuMidpoint::step(NavState& state, const ImuSample& from, const ImuSample& to) const {
  const ImuMean u(state, from, to);
  // eq. MOT-1: rotate the force by the attitude in the middle; the start attitude would lag by half a step.
  const Vec3 a_W = state.R * (exp_so3(0.5 * u.dt * u.w) * u.a) + state.g;
  MotionSegment segment{from.t, u.dt, state.R, state.p, state.v, u.w, a_W};
  if (rate_ == Rate::linear) segment.w_dot = u.w_change - state.S_w * u.w_change;  // eq. MOT-10
  state.R = orthonormalised(state.R * exp_so3(u.dt * u.w));
  state.p += u.dt * state.v + 0.5 * u.dt * u.dt * a_W;
  state.v += u.dt * a_W;
  state.t = to.t;
  return segment;
}

void ImuMidpoint::propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to,
                                       const ImuNoise& noise, StateMatrix& P) const {
  midpoint_transition(before, from, to).apply(noise, P);
}

void ImuMidpoint::linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                            Eigen::Matrix<double, kStateDim, 12>& G) const {
  midpoint_transition(before, from, to).dense(F, G);
}

}  // namespace aslio::plugins
