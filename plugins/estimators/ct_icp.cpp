#include "estimators/ct_icp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "aslio/core/angles.hpp"
#include "aslio/core/cpu_clock.hpp"

namespace aslio::plugins {

namespace {

constexpr std::size_t kPointsPerChunk = 256;  // points per chunk of a reduction
double angle_between(const Mat3& a, const Mat3& b) { return log_so3(a.transpose() * b).norm(); }

}  // namespace

CtIcp::CtIcp(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      residual_(params.residual.make(context)),
      imu_(params.imu, context),
      frame_(context.sensor) {
  trajectory_.reserve(1);
}

void CtIcp::reset(const InitialState& initial) {
  initial_ = initial;
  velocity_.begin(initial);
  state_ = initial.state;
  P_.setZero();
  twist_ = {};
  twist_.begin(initial.rate, initial.state.R.transpose() * initial.state.v);
  imu_.reset(initial);
  result_ = Update{};
}

NavState CtIcp::predict(std::span<const ImuSample> imu) const {
  if (uses_imu()) return imu_.predict(state_, imu);
  return imu.empty() ? state_ : twist_.predict(state_, imu.back().t);
}

void CtIcp::propagate(const Window& window) {
  const CpuTimer timer(result_.times.predict);
  begin_ = state_;
  state_ = uses_imu() ? imu_.propagate(state_, window) : twist_.predict(state_, window.plan.end);
  prior_ = state_;
  set_path(begin_.pose(), prior_.pose());
}

void CtIcp::set_path(const Pose& begin, const Pose& end) {
  path_.set(begin_.t, begin, prior_.t, end);
  NavState from = begin_, to = prior_;
  from.R = begin.R;
  from.p = begin.p;
  to.R = end.R;
  to.p = end.p;
  const double length = std::max(to_seconds(to.t - from.t), 1e-9);
  trajectory_.clear(from);
  trajectory_.append({from.t, length, begin.R, begin.p, (end.p - begin.p) / length,
                      log_so3(begin.R.transpose() * end.R) / length, Vec3::Zero()},
                     to);
}

void CtIcp::load(const Window& window, const HistorySelection& past, const StepContext& context) {
  frame_.load(window.fresh, trajectory_, context.samplers, result_.times);
  const CpuTimer timer(result_.times.sample);
  const std::size_t fresh = frame_.match_body().size(), old = past.points.size();
  fresh_.reserve(fresh, *residual_);
  history_.reserve(std::max(fresh, old), *residual_);
  if (share_.capacity() < fresh) share_.reserve(2 * fresh);
  if (records_.capacity() < fresh) records_.reserve(2 * fresh);
  fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
  fresh_.range.assign(frame_.match_range().begin(), frame_.match_range().end());
  share_.clear();
  for (const TimeNs t : frame_.match_time()) share_.push_back(path_.share(t));
  history_.load(past, prior_.pose());
  result_.history_points = static_cast<std::uint32_t>(old);
}

/// Every point where the path says that it was measured.
void CtIcp::place() {
  {
    const CpuTimer timer(result_.times.deskew, result_.times.solve);
    frame_.deskew_matches(trajectory_);
    fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
  }
  fresh_.place(path_.end());
  history_.place(path_.end());
}

void CtIcp::associate(const HistorySelection& past, const StepContext& context) {
  const CpuTimer timer(result_.times.associate, result_.times.solve);
  const Vec3 viewpoint = frame_.viewpoint(path_.end());
  fresh_.associate(context.map, *residual_, viewpoint, 0xffffffff);
  if (!history_.body.empty()) history_.associate(context.map, *residual_, viewpoint, past.max_stamp);
}

BeginEndInformation CtIcp::measure(PointMatches& matches, bool fresh, double gate) {
  matches.evaluate(*residual_, params_.sigma);
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  const std::size_t n = matches.body.size();
  partials_.resize(exec::Executor::chunk_count(n, kPointsPerChunk));
  const BeginEnd::At end = path_.at(1.0);
  return exec_.reduce(
      n, kPointsPerChunk, BeginEndInformation{}, std::span<BeginEndInformation>(partials_),
      [&](std::size_t first, std::size_t last) {
        BeginEndInformation out;
        for (std::size_t i = first; i < last; ++i) {
          const auto match = std::span<const ResidualRow>(matches.rows).subspan(i * rows, rows);
          if (!within(match, gate * gate)) continue;
          const BeginEnd::At at = fresh ? path_.at(share_[i]) : end;
          const double weight = matches.weight.empty() ? 1.0 : matches.weight[i];
          for (const ResidualRow& z : match)
            if (z.takes_part()) out.add(at, matches.world[i], z.J, z.r, weight * z.information);
        }
        return out;
      },
      [](BeginEndInformation& total, const BeginEndInformation& part) { total += part; });
}

/// eq. CT-3.
void CtIcp::add_priors(Mat12& A, Vec12& b, double points) const {
  const double unit = points / (params_.sigma * params_.sigma);
  const Pose &begin = path_.begin(), &end = path_.end();
  const auto add = [&](double weight, const Vec3& z, const Eigen::Matrix<double, 3, 12>& h) {
    if (weight == 0) return;
    A.noalias() += weight * unit * h.transpose() * h;
    b.noalias() += weight * unit * h.transpose() * z;
  };
  Eigen::Matrix<double, 3, 12> h = Eigen::Matrix<double, 3, 12>::Zero();
  h.middleCols<3>(3).setIdentity();
  add(params_.location, begin.p - begin_.p, h);
  h.middleCols<3>(9).setIdentity();
  h.middleCols<3>(3) *= -1.0;
  add(params_.displacement, end.p - begin.p - (prior_.p - begin_.p), h);

  const Vec3 off = log_so3(begin_.R.transpose() * begin.R);
  h.setZero();
  h.middleCols<3>(0) = right_jacobian_inverse_so3(off);
  add(params_.orientation, off, h);
  const Mat3 turned = begin.R.transpose() * end.R;
  const Vec3 excess = log_so3((begin_.R.transpose() * prior_.R).transpose() * turned);
  const Mat3 rate = right_jacobian_inverse_so3(excess);
  h.setZero();
  h.middleCols<3>(0) = -rate * turned.transpose();
  h.middleCols<3>(6) = rate;
  add(params_.turn, excess, h);
}

/// One Gauss-Newton step; false when it was refused. `turn` [rad] and `shift` [m] are the larger of both ends.
bool CtIcp::step(const StepContext& context, double& turn, double& shift) {
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  last_ = measure(fresh_, true, std::numeric_limits<double>::infinity());
  const double gate = context.histories.gate(params_.sigma);
  const BeginEndInformation old = measure(history_, false, gate);
  result_.fresh_matches = static_cast<std::uint32_t>(count_matches(fresh_.rows, rows, last_.accepted));
  result_.history_matches = static_cast<std::uint32_t>(count_matches(history_.rows, rows, old.accepted, gate * gate));
  if (static_cast<std::int64_t>(result_.fresh_matches) < params_.min_matches) {
    refuse(UpdateStatus::few_matches);
    return false;
  }
  const double weight = context.histories.weight(last_.accepted, old.accepted);
  Mat12 A = last_.A + weight * old.A;
  Vec12 b = last_.b + weight * old.b;
  add_priors(A, b, static_cast<double>(last_.accepted));
  A.diagonal() *= 1.0 + 1e-6;
  const Vec12 delta = -A.ldlt().solve(b);
  if (!delta.allFinite()) {
    refuse(UpdateStatus::non_finite);
    return false;
  }
  const auto moved = [](const Pose& pose, const Vec6& by) {
    const Pose there = pose.moved(by);
    return Pose{orthonormalised(there.R), there.p};
  };
  set_path(moved(path_.begin(), delta.head<6>()), moved(path_.end(), delta.tail<6>()));
  turn = std::max(delta.segment<3>(0).norm(), delta.segment<3>(6).norm());
  shift = std::max(delta.segment<3>(3).norm(), delta.segment<3>(9).norm());
  return true;
}

void CtIcp::iterate(const HistorySelection& past, const StepContext& context) {
  const CpuTimer timer(result_.times.solve);
  const double enough_turn = params_.converged_deg * kRadPerDeg, enough_shift = params_.converged_m;
  for (int j = 0; j < params_.max_iterations; ++j) {
    const Pose begin = path_.begin(), end = path_.end();
    place();
    associate(past, context);
    result_.iterations = j + 1;
    for (int s = 0; s < params_.max_steps; ++s) {
      double turn = 0, shift = 0;
      if (s > 0) place();
      if (!step(context, turn, shift)) return;
      if (turn < 0.1 * enough_turn && shift < 0.1 * enough_shift) break;
    }
    const double turn = std::max(angle_between(begin.R, path_.begin().R), angle_between(end.R, path_.end().R));
    const double shift = std::max((begin.p - path_.begin().p).norm(), (end.p - path_.end().p).norm());
    const bool converged = turn < enough_turn && shift < enough_shift;
    if (!converged && j + 1 < params_.max_iterations) continue;
    result_.status = status_of_last_step(settled(turn, enough_turn) && settled(shift, enough_shift));
    return accept();
  }
}

void CtIcp::accept() {
  // What is known of the end: the points, and how firmly the begin is held; what was predicted is no evidence.
  Mat12 known = last_.A;
  const double unit = static_cast<double>(last_.accepted) / (params_.sigma * params_.sigma);
  known.diagonal().segment<3>(0).array() += unit * params_.orientation;
  known.diagonal().segment<3>(3).array() += unit * params_.location;
  const Mat6 information = end_information(known);
  judge_view(result_, information, params_.degenerate_sigma, plan_);
  if (uses_imu()) {
    state_ = imu_.correct(prior_, path_.end(), information);
    set_path(path_.begin(), state_.pose());
    if (velocity_.active()) find_velocity_alone();
  } else {
    state_.R = path_.end().R;
    state_.p = path_.end().p;
    twist_.follow(state_.pose(), state_.t);
    state_.v = state_.R * twist_.velocity_in_body();
    P_.topLeftCorner<6, 6>() = bounded_covariance(information);
  }
  if (uses_imu()) twist_.hold(state_.pose(), state_.t);
  result_.accepted = true;
}

/// eq. INI-3: the first windows were predicted with a wrong velocity, and the map holds what they smeared.
void CtIcp::find_velocity_alone() {
  velocity_.step(plan_, state_);
  InitialState known = initial_;
  known.sigma_velocity = velocity_.sigma_velocity();
  imu_.reset(known);
  result_.restart_map = true;
}

void CtIcp::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  set_path(begin_.pose(), prior_.pose());
  result_.insert = status == UpdateStatus::few_matches && twist_.believed(state_.t);
}

const Update& CtIcp::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  const NavState before = state_;
  propagate(window);
  const bool finite = state_.R.allFinite() && state_.p.allFinite() && state_.v.allFinite();
  if (!finite) {  // back to the last finite state
    state_ = prior_ = before;
    state_.t = prior_.t = window.plan.end;
    set_path(before.pose(), before.pose());
    refuse(UpdateStatus::non_finite);
  }
  result_.prior = state_;
  load(window, past, context);
  if (finite && context.map.size() == 0) {
    result_.status = UpdateStatus::initialising;
    twist_.hold(state_.pose(), state_.t);
  } else if (finite) {
    iterate(past, context);
  }
  finish();
  return result_;
}

void CtIcp::finish() {
  {
    const CpuTimer timer(result_.times.deskew);
    frame_.deskew(trajectory_);
  }
  const CpuTimer timer(result_.times.solve);
  frame_.place(trajectory_);
  records_.assign(fresh_.body.size(), MatchRecord{});
  if (result_.accepted) {
    place();
    fresh_.evaluate(*residual_, params_.sigma);
    fresh_.record(static_cast<std::size_t>(residual_->rows_per_match()), records_, result_.residual_rms);
    if (!residual_->surfaces_from_map()) result_.neighbours = &fresh_.neighbours;
  }
  result_.P = uses_imu() ? imu_.P() : P_;
  hand_over(result_, frame_, records_, state_, {&state_, 1}, path_);
}

}  // namespace aslio::plugins
