#include "estimators/fixed_lag_smoother.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::plugins {

void FixedLagSmoother::describe(config::Binder& b, Params& p) {
  LagWindow::Params& w = p.window;
  b.integer("lag", w.lag, "", {.min = 2, .max = 1000}, "states that are smoothed together");
  b.integer("max_iterations", w.max_iterations, "", {.min = 1, .max = 1000}, "iterations of the smoother at most");
  b.real("sigma_rotation", w.sigma_rotation, "rad", {.above = 0, .max = 10},
         "standard deviation of an estimated attitude");
  b.real("sigma_position", w.sigma_position, "m", {.above = 0, .max = 100}, "the same of an estimated position");
  b.real("sigma_degenerate", w.sigma_degenerate, "", {.above = 0, .max = 1e6},
         "both (rad, m) where the front says that a direction was open");
  b.real("gyro_noise", w.noise.gyro, "rad/s/sqrt(Hz)", {.above = 0, .max = 10}, "density of the gyro's noise");
  b.real("acc_noise", w.noise.acc, "m/s^2/sqrt(Hz)", {.above = 0, .max = 100}, "density of the accelerometer's noise");
  b.real("gyro_bias_walk", w.noise.gyro_bias, "rad/s^2/sqrt(Hz)", {.above = 0, .max = 10}, "walk of the gyro's bias");
  b.real("acc_bias_walk", w.noise.acc_bias, "m/s^3/sqrt(Hz)", {.above = 0, .max = 10},
         "walk of the accelerometer's bias");
  b.real("integration_noise", w.noise.integration, "m/sqrt(s)", {.above = 0, .max = 1},
         "what the integration of positions adds");
  b.real("max_speed", p.max_speed, "m/s", {.above = 0}, "with a faster state the smoother starts again");
  b.real("max_bias", p.max_bias, "", {.above = 0}, "the same with a bias beyond this (rad/s, m/s^2)");
  b.stage("motion", p.motion, "pose and velocity ahead of the last update");
  b.stage("front", p.front, "what finds the pose of a window");
}

FixedLagSmoother::FixedLagSmoother(const Params& params, const BuildContext& context)
    : params_(params),
      motion_(params.motion.make(context)),
      front_(params.front.make(context)),
      window_(params.window) {
  const std::string& front = params.front.type();
  if (!front_->uses_imu()) {
    throw ConfigError(
        fmt::format("estimator fixed_lag_smoother: front: '{}' uses no IMU data, but must start from the prediction of "
                    "the IMU: set prediction: imu, or another front",
                    front));
  }
  if (front_->smooths()) {
    throw ConfigError(fmt::format(
        "estimator fixed_lag_smoother: front: '{}' starts its smoothing again after every update, when it receives a "
        "velocity and biases. So it never smooths: set another front, or make it the estimator itself",
        front));
  }
}

void FixedLagSmoother::reset(const InitialState& initial) {
  initial_ = initial;
  state_ = initial.state;
  front_->reset(initial);
  window_.clear();
  result_ = Update{};
}

void FixedLagSmoother::adopt(const InertialEstimate& better) {
  better.put(state_);
  front_->adopt(better);
  window_.clear();  // what it knew of them is another's
}

NavState FixedLagSmoother::predict(std::span<const ImuSample> imu) const {
  NavState state = state_;
  for (std::size_t i = 1; i < imu.size(); ++i) motion_->step(state, imu[i - 1], imu[i]);
  return state;
}

void FixedLagSmoother::start_window(const NavState& state, double sigma_velocity) {
  constexpr double pose = 0.01;  // [rad], [m]: the world is where the first state is
  Vec15 sigma;
  sigma << initial_.sigma_tilt, initial_.sigma_tilt, pose, Vec3::Constant(pose),
      Vec3::Constant(std::max(sigma_velocity, pose)), Vec3::Constant(initial_.sigma_gyro_bias),
      Vec3::Constant(initial_.sigma_acc_bias);
  window_.start(state, sigma);
}

bool FixedLagSmoother::plausible(const NavState& state) const {
  return state.v.norm() <= params_.max_speed && state.b_w.norm() <= params_.max_bias &&
         state.b_a.norm() <= params_.max_bias;  // false for what is not a number
}

void FixedLagSmoother::smooth(const Preintegration& motion, const Update& found) {
  const CpuTimer timer(result_.times.solve);
  NavState guess = found.state;
  guess.v = found.prior.v;
  guess.b_w = window_.newest().b_w;
  guess.b_a = window_.newest().b_a;
  window_.append(motion, guess);
  if (found.accepted) window_.measure(found.state.pose(), found.unobservable_direction());
  if (window_.solve() && plausible(window_.newest())) {
    InertialEstimate::of(window_.newest()).put(state_);
    return;
  }
  // Lost: begin again where the registration stands, with what initialisation knew of the IMU. Nobody knows how fast.
  state_.b_w = initial_.state.b_w;
  state_.b_a = initial_.state.b_a;
  if (!plausible(state_)) state_.v.setZero();
  constexpr double sigma_velocity = 3.0;  // [m/s] as at a start in motion
  start_window(state_, std::max(sigma_velocity, initial_.sigma_velocity));
}

const Update& FixedLagSmoother::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  if (window_.empty()) start_window(state_, initial_.sigma_velocity);
  const Update& found = front_->update(window, past, context);
  result_ = found;
  state_ = found.state;
  NavState reading = state_;  // with the calibration that the front has found by now
  InertialEstimate::of(window_.newest()).put(reading);
  const Preintegration motion(window.imu, reading, params_.window.noise.over(window.imu_gap));
  if (found.restart_map) {
    window_.clear();  // the front searches its velocity (INI-3): what was found so far was as wrong as that
  } else if (motion.seconds > 0) {
    smooth(motion, found);
  }
  front_->adopt(InertialEstimate::of(state_));
  result_.state = state_;
  result_.states = {&state_, 1};
  result_.P.setZero();
  result_.P.topLeftCorner<kNodeDim, kNodeDim>() = window_.covariance();
  return result_;
}

}  // namespace aslio::plugins
