#include "my_stage.hpp"

#include <Eigen/Cholesky>

#include "aslio/plugin/entry.hpp"
#include "aslio/toolkit/gyro_motion.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.integer("max_iterations", p.rules.max_iterations, "", {.min = 1, .max = 1000}, "iterations at most");
  b.real("converged", p.rules.converged, "", {.above = 0.0, .max = 1.0}, "length of the last step, rad and m alike");
  b.integer("min_matches", p.rules.min_matches, "", {.min = 3, .max = 1e6}, "fewer fresh matches: the step is refused");
  b.real("sigma", p.sigma, "m", {.above = 0.0, .max = 10.0}, "standard deviation of a residual");
  b.real("sigma_rotation", p.sigma_rotation, "rad", {.above = 0.0, .max = 1.0}, "of the prediction over a window");
  b.real("sigma_position", p.sigma_position, "m", {.above = 0.0, .max = 10.0}, "of the prediction over a window");
  b.stage("residual", p.residual, "what a match measures");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : Registration(params.rules, params.residual.make(context), context), params_(params) {
  prior_information_.diagonal() << Vec3::Constant(1.0 / (params.sigma_rotation * params.sigma_rotation)),
      Vec3::Constant(1.0 / (params.sigma_position * params.sigma_position));
}

NavState MyStage::predict(std::span<const ImuSample> imu) const {
  NavState out = state();
  for (std::size_t i = 1; i < imu.size(); ++i) turn_and_coast(out, imu[i - 1], imu[i]);
  return out;
}

/// De-skew is done along what is appended here.
NavState MyStage::propagate(const Window& window, WindowTrajectory& trajectory) {
  NavState out = state();
  begin_ = out.pose();
  seconds_ = to_seconds(window.plan.end - out.t);
  for (std::size_t i = 1; i < window.imu.size(); ++i) {
    const MotionSegment segment = turn_and_coast(out, window.imu[i - 1], window.imu[i]);
    trajectory.append(segment, out);
  }
  out.t = window.plan.end;  // also of a window without IMU data
  return out;
}

/// The prediction is one measurement more.
Vec6 MyStage::step(const Pose& prior, const Pose& at, const PoseInformation& all) const {
  Vec6 off;
  off << log_so3(prior.R.transpose() * at.R), at.p - prior.p;
  const Mat6 A = all.A + prior_information_;
  return -A.ldlt().solve(all.b + prior_information_ * off);
}

Mat6 MyStage::accept(const Pose& end, const PoseInformation& fresh, NavState& state, StateMatrix& P) {
  state.v = (end.p - begin_.p) / seconds_;
  state.R = end.R;
  state.p = end.p;
  P.topLeftCorner<6, 6>() = bounded_covariance(fresh.A + prior_information_);
  return fresh.A;
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Estimator>(catalog).add<MyStage>(
      "my_stage", "Registration by Gauss-Newton steps from a prediction of gyro and velocity.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
