#include "estimators/icp.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace aslio::plugins {

namespace {
constexpr int kPieces = 4;  // of a window, within which the path of a constant twist is taken for a parabola
}  // namespace

void Icp::describe(config::Binder& b, Params& p) {
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 1e4}, "iterations at most");
  b.real("converged", p.converged, "", {.above = 0, .max = 1},
         "length of a step (rad and m alike) below which an iteration has converged");
  b.integer("min_matches", p.min_matches, "", {.min = 3, .max = 1e6}, "fewer fresh matches: the step is refused");
  b.real("initial_threshold", p.initial_threshold, "m", {.above = 0, .max = 100},
         "sigma of the residual before anything has been learnt");
  b.real("min_motion", p.min_motion, "m", {.min = 0, .max = 10},
         "what the prediction was off by less than this is not learnt from");
  b.real("degenerate_sigma", p.degenerate_sigma, "m", {.above = 0, .max = 100},
         "an update is marked degenerate when 0.1 s of its view know their weakest direction worse than this "
         "(rotation at a 5 m lever arm)");
  b.stage("residual", p.residual, "what a match measures; its sigma is the learnt threshold");
}

Icp::Icp(const Params& params, const BuildContext& context)
    : Registration({params.max_iterations, params.converged, params.min_matches, params.degenerate_sigma},
                   params.residual.make(context), context),
      params_(params),
      max_range_(context.sensor.max_range) {}

void Icp::reset(const InitialState& initial) {
  restart(initial.state);
  twist_ = {};
  twist_.begin(initial.rate, initial.state.R.transpose() * initial.state.v);
  squared_deviations_ = params_.initial_threshold * params_.initial_threshold;
  deviations_ = 1;
}

NavState Icp::predict(std::span<const ImuSample> imu) const {
  return imu.empty() ? state() : twist_.predict(state(), imu.back().t);
}

/// eq. TRJ-2, in pieces.
NavState Icp::propagate(const Window& window, WindowTrajectory& trajectory) {
  const NavState& begin = state();
  const TimeNs length = window.plan.end - begin.t;
  NavState from = begin;
  for (int i = 1; i <= kPieces; ++i) {
    const NavState to = twist_.predict(begin, begin.t + length * i / kPieces);
    const Vec3 v = from.R * twist_.velocity_in_body();
    trajectory.append({from.t, to_seconds(to.t - from.t), from.R, from.p, v, twist_.rate(),
                       from.R * twist_.rate().cross(twist_.velocity_in_body())},
                      to);
    from = to;
  }
  return from;
}

/// eq. ICP-2.
double Icp::threshold() const { return std::sqrt(squared_deviations_ / deviations_); }

void Icp::learn_threshold(const Pose& predicted, const Pose& found) {
  const Pose deviation = predicted.inverse() * found;
  const double turn = log_so3(deviation.R).norm();
  const double error = 2.0 * max_range_ * std::sin(0.5 * turn) + deviation.p.norm();
  if (error <= params_.min_motion) return;
  squared_deviations_ += error * error;
  ++deviations_;
}

/// eqs. ICP-1, ICP-3.
Mat6 Icp::accept(const Pose& end, const PoseInformation& fresh, NavState& state, StateMatrix& P) {
  // The threshold says how far matches may lie, not how noisy they are: that, the residuals themselves say.
  constexpr double least_variance = 1e-6;  // [m^2]
  const double variance = std::max(least_variance, fresh.squared_sum / static_cast<double>(fresh.accepted));
  const Mat6 fresh_information = fresh.A * (threshold() * threshold() / variance);
  learn_threshold(state.pose(), end);
  twist_.follow(end, state.t);
  state.R = end.R;
  state.p = end.p;
  state.v = end.R * twist_.velocity_in_body();
  P.setZero();
  P.topLeftCorner<6, 6>() = bounded_covariance(fresh_information);
  return fresh_information;
}

}  // namespace aslio::plugins
