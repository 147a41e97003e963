#include "estimators/icp.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "aslio/core/cpu_clock.hpp"

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
    : params_(params),
      exec_(context.exec),
      max_range_(context.sensor.max_range),
      residual_(params.residual.make(context)),
      frame_(context.sensor) {
  trajectory_.reserve(kPieces);
}

void Icp::reset(const InitialState& initial) {
  state_ = initial.state;
  P_.setZero();
  twist_ = {};
  twist_.begin(initial.rate, initial.state.R.transpose() * initial.state.v);
  squared_deviations_ = params_.initial_threshold * params_.initial_threshold;
  deviations_ = 1;
  result_ = Update{};
}

NavState Icp::predict(std::span<const ImuSample> imu) const {
  return imu.empty() ? state_ : twist_.predict(state_, imu.back().t);
}

/// eq. TRJ-2, in pieces.
void Icp::propagate(TimeNs end) {
  const CpuTimer timer(result_.times.predict);
  begin_ = state_.pose();
  trajectory_.clear(state_);
  const TimeNs length = end - state_.t;
  NavState from = state_;
  for (int i = 1; i <= kPieces; ++i) {
    const NavState to = twist_.predict(state_, state_.t + length * i / kPieces);
    const Vec3 v = from.R * twist_.velocity_in_body();
    trajectory_.append({from.t, to_seconds(to.t - from.t), from.R, from.p, v, twist_.rate(),
                        from.R * twist_.rate().cross(twist_.velocity_in_body())},
                       to);
    from = to;
  }
  state_ = from;
}

void Icp::load(const Window& window, const HistorySelection& past, const StepContext& context) {
  frame_.load(window.fresh, trajectory_, context.samplers, result_.times);
  const CpuTimer timer(result_.times.sample);
  const std::size_t fresh = frame_.match_body().size(), old = past.points.size();
  fresh_.reserve(fresh, *residual_);
  history_.reserve(std::max(fresh, old), *residual_);
  if (records_.capacity() < fresh) records_.reserve(2 * fresh);
  fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
  fresh_.range.assign(frame_.match_range().begin(), frame_.match_range().end());
  history_.load(past, state_.pose());
  result_.history_points = static_cast<std::uint32_t>(old);
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

PoseInformation Icp::sum(PointMatches& matches, const Pose& at, double gate) {
  matches.evaluate(*residual_, threshold());
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  const Mat3 Rt = at.R.transpose();
  const std::size_t n = matches.body.size();
  partials_.resize(exec::Executor::chunk_count(n, kGrain));
  return exec_.reduce(
      n, kGrain, PoseInformation{}, std::span<PoseInformation>(partials_),
      [&](std::size_t begin, std::size_t end) {
        PoseInformation out;
        for (std::size_t i = begin; i < end; ++i) {
          const auto match = std::span<const ResidualRow>(matches.rows).subspan(i * rows, rows);
          if (!within(match, gate * gate)) continue;
          const double weight = matches.weight.empty() ? 1.0 : matches.weight[i];
          for (const ResidualRow& z : match)
            if (z.takes_part()) out.add(matches.body[i], Rt, z.J, z.r, weight * z.information);
        }
        return out;
      },
      [](PoseInformation& total, const PoseInformation& part) { total += part; });
}

/// eq. ICP-1.
void Icp::iterate(const HistorySelection& past, const StepContext& context) {
  const Pose prior = state_.pose();
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  Pose end = prior;
  for (int j = 0; j < params_.max_iterations; ++j) {
    {
      const CpuTimer timer(result_.times.associate);
      fresh_.place(end);
      history_.place(end);
      const Vec3 viewpoint = frame_.viewpoint(end);
      fresh_.associate(context.map, *residual_, viewpoint, 0xffffffff);
      if (!history_.body.empty()) history_.associate(context.map, *residual_, viewpoint, past.max_stamp);
    }
    const CpuTimer timer(result_.times.solve);
    const PoseInformation fresh = sum(fresh_, end, std::numeric_limits<double>::infinity());
    const PoseInformation old = sum(history_, end, context.histories.gate(threshold()));
    result_.iterations = j + 1;
    result_.fresh_matches = static_cast<std::uint32_t>(fresh.accepted / rows);
    result_.history_matches = static_cast<std::uint32_t>(old.accepted / rows);
    if (static_cast<std::int64_t>(result_.fresh_matches) < params_.min_matches) {
      return refuse(UpdateStatus::few_matches);
    }
    const double share = context.histories.weight(fresh.accepted, old.accepted);
    const Vec6 step = -(fresh.A + share * old.A).ldlt().solve(fresh.b + share * old.b);
    if (!step.allFinite()) return refuse(UpdateStatus::non_finite);
    end = end.moved(step);
    end.R = orthonormalised(end.R);
    if (step.norm() < params_.converged || j + 1 == params_.max_iterations) {
      // A last step ten times too long is noise of the association; a longer one says that the pose is on its way.
      result_.status = step.norm() < 10 * params_.converged ? UpdateStatus::ok : UpdateStatus::not_converged;
      return accept(end, fresh);
    }
  }
}

void Icp::accept(const Pose& end, const PoseInformation& fresh) {
  // The threshold says how far matches may lie, not how noisy they are: that, the residuals themselves say (eq. ICP-3).
  constexpr double least_variance = 1e-6;  // [m^2]
  const double variance = std::max(least_variance, fresh.squared_sum / static_cast<double>(fresh.accepted));
  const Mat6 fresh_information = fresh.A * (threshold() * threshold() / variance);
  set_spectrum(result_, fresh_information);
  result_.left_open = leaves_open(result_.spectrum, params_.degenerate_sigma, plan_);
  if (result_.status == UpdateStatus::ok && result_.left_open) result_.status = UpdateStatus::degenerate;
  learn_threshold(state_.pose(), end);
  twist_.follow(end, state_.t);
  state_.R = end.R;
  state_.p = end.p;
  state_.v = end.R * twist_.velocity_in_body();
  P_.setZero();
  P_.topLeftCorner<6, 6>() = bounded_covariance(fresh_information);
  result_.accepted = true;
}

void Icp::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  result_.insert = status == UpdateStatus::few_matches && twist_.believed(state_.t);
}

const Update& Icp::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  matched_within_ = threshold();  // the update itself teaches it another one
  propagate(window.plan.end);
  result_.prior = state_;
  load(window, past, context);
  if (context.map.size() == 0) {
    result_.status = UpdateStatus::initialising;
    twist_.hold(state_.pose(), state_.t);
  } else {
    iterate(past, context);
  }
  finish();
  return result_;
}

void Icp::finish() {
  const CpuTimer timer(result_.times.solve);
  trajectory_.correct(state_.pose());
  frame_.place(trajectory_);
  records_.assign(fresh_.body.size(), MatchRecord{});
  if (result_.accepted) {
    fresh_.place(state_.pose());
    fresh_.evaluate(*residual_, matched_within_);
    fresh_.record(static_cast<std::size_t>(residual_->rows_per_match()), records_, result_.residual_rms);
    if (!residual_->surfaces_from_map()) result_.neighbours = &fresh_.neighbours;
  }
  result_.state = state_;
  result_.P = P_;
  result_.states = {&state_, 1};
  result_.trajectory = &trajectory_;
  result_.matches = records_;
  result_.overlap_points = frame_.world(Tap::overlap);
  result_.map_points = frame_.world(Tap::map);
  result_.match_points = frame_.world(Tap::match);
}

}  // namespace aslio::plugins
