#include "estimators/scan_matcher.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/cpu_clock.hpp"

namespace aslio::plugins {

namespace {
std::uint8_t class_of(std::uint8_t feature) { return static_cast<std::uint8_t>(feature & ~feature_class::clearest); }
}  // namespace

void ScanMatcher::reset(const InitialState& initial) {
  state_ = initial.state;
  P_.setZero();
  twist_ = {};
  twist_.begin(initial.rate, initial.state.R.transpose() * initial.state.v);
  imu_.reset(initial);
  for (Kind* kind : {&lines_, &planes_}) kind->last_sweep.clear();
  result_ = Update{};
}

NavState ScanMatcher::predict(std::span<const ImuSample> imu) const {
  if (uses_imu()) return imu_.predict(state_, imu);
  return imu.empty() ? state_ : twist_.predict(state_, imu.back().t);
}

void ScanMatcher::propagate(const Window& window) {
  const CpuTimer timer(result_.times.predict);
  const NavState begin = state_;
  trajectory_.clear(begin);
  if (uses_imu()) {
    prior_ = state_ = imu_.propagate(begin, window, &trajectory_);
    return;
  }
  prior_ = state_ = twist_.predict(state_, window.plan.end);
  const double length = std::max(to_seconds(prior_.t - begin.t), 1e-9);
  trajectory_.append({begin.t, length, begin.R, begin.p, (prior_.p - begin.p) / length,
                      log_so3(begin.R.transpose() * prior_.R) / length, Vec3::Zero()},
                     prior_);
}

void ScanMatcher::load(const Window& window, const StepContext& context) {
  frame_.load(window.fresh, trajectory_, context.samplers, result_.times);
  const CpuTimer timer(result_.times.sample);
  const auto features = frame_.match_feature();
  for (Kind* kind : {&lines_, &planes_}) {
    if (kind->index.capacity() < features.size()) kind->index.reserve(2 * features.size());
    kind->all.reserve(features.size(), *kind->residual);
    kind->all.body.clear();
    kind->all.range.clear();
    kind->all.surfaces.clear();
    kind->index.clear();
  }
  for (std::size_t i = 0; i < features.size(); ++i) {
    Kind& kind = class_of(features[i]) == feature_class::line ? lines_ : planes_;
    kind.index.push_back(static_cast<std::uint32_t>(i));
    kind.all.body.push_back(frame_.match_body()[i]);
    kind.all.range.push_back(frame_.match_range()[i]);
  }
  if (records_.capacity() < features.size()) {
    records_.reserve(2 * features.size());
    own_records_.reserve(2 * features.size());
  }
}

ScanMatcher::MatchSum ScanMatcher::measure(PointMatches& matches, Residual& residual, const Pose& at) {
  matches.evaluate(residual, params_.sigma);
  const auto rows = static_cast<std::size_t>(residual.rows_per_match());
  const Mat3 Rt = at.R.transpose();
  const std::size_t n = matches.body.size();
  partials_.resize(exec::Executor::chunk_count(n, kGrain));
  return exec_.reduce(
      n, kGrain, MatchSum{}, std::span<MatchSum>(partials_),
      [&](std::size_t begin, std::size_t end) {
        MatchSum out;
        for (std::size_t i = begin; i < end; ++i) {
          std::size_t used = 0;
          for (std::size_t row = i * rows; row < (i + 1) * rows; ++row) {
            const ResidualRow& z = matches.rows[row];
            if (!z.takes_part()) continue;
            out.add(matches.body[i], Rt, z.J, z.r, z.information);
            ++used;
          }
          out.rows += used;
          out.accepted -= used > 1 ? used - 1 : 0;  // matches, not rows
        }
        return out;
      },
      [](MatchSum& total, const MatchSum& part) { total += part; });
}

/// The projection onto directions whose eigenvalue of J^T W J is not too small. eq. SWP-3
void ScanMatcher::hold_directions(Descent& at) const {
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(params_.sigma * params_.sigma * at.sum.A);
  at.held.setZero();
  at.degenerate = false;
  for (int i = 0; i < 6; ++i) {
    if (solver.eigenvalues()[i] < params_.degenerate_eigenvalue) {
      at.degenerate = true;
    } else {
      at.held += solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose();
    }
  }
}

/// One step of Gauss-Newton within the directions `held`.
ScanMatcher::Step ScanMatcher::move(const MatchSum& sum, const Mat6& held, Pose& end) {
  Mat6 A = sum.A;
  A.diagonal().array() += 1e-9 * (1.0 + A.trace());
  const Vec6 step = -held * A.ldlt().solve(sum.b);
  if (!step.allFinite()) return Step::refused;
  end = end.moved(step);
  end.R = orthonormalised(end.R);
  const bool small =
      step.head<3>().norm() < params_.converged_deg * kRadPerDeg && step.tail<3>().norm() < params_.converged_m;
  return small ? Step::small : Step::moved;
}

/// Gauss-Newton over the matches of one search. False: too little is matched, or a step is not finite.
bool ScanMatcher::descend(PointMatches Kind::*points, bool first, Descent& at) {
  ++result_.iterations;
  for (int j = 0; j < params_.max_steps; ++j) {
    at.sum = {};
    for (Kind* kind : {&lines_, &planes_}) {
      (kind->*points).place(at.end);
      at.sum += measure(kind->*points, *kind->residual, at.end);
    }
    at.matches = static_cast<std::uint32_t>(at.sum.accepted);
    if (static_cast<std::int64_t>(at.matches) < params_.min_matches) return false;
    if (first && j == 0) hold_directions(at);
    const Step step = move(at.sum, at.held, at.end);
    if (step == Step::refused) {
      not_finite_ = true;
      return false;
    }
    at.converged = step == Step::small;
    at.settled = at.converged && j == 0;
    if (at.converged) break;
  }
  return true;
}

void ScanMatcher::take(const Descent& at) {
  before_ = last_;
  last_ = at;
  result_.fresh_matches = at.matches;
  trajectory_.correct(at.end);
}

/// What it found out is no part of a registration that was taken before it.
bool ScanMatcher::drop(const Descent& at) {
  if (!last_) result_.fresh_matches = at.matches;
  return false;
}

/// eq. SWP-2. False: the pose stays.
bool ScanMatcher::match_map(const Map& map) {
  const CpuTimer timer(result_.times.solve);
  Descent at{.end = trajectory_.corrected_end()};
  for (int search = 0; search < params_.map_searches && !at.settled; ++search) {
    {
      const CpuTimer searching(result_.times.associate, result_.times.solve);
      for (Kind* kind : {&lines_, &planes_}) {
        kind->all.place(at.end);
        kind->all.associate(map, *kind->residual, frame_.viewpoint(at.end), 0xffffffff, kind->feature);
      }
    }
    if (!descend(&Kind::all, search == 0, at)) return drop(at);
  }
  take(at);
  return true;
}

/// What a registration knows in the directions in which it may move. The kernel bounds matches whose noise nobody
/// knows: the residuals themselves tell it (eq. ICP-3).
Mat6 ScanMatcher::measured(const Descent& at) const {
  constexpr double least_variance = 1e-6;  // [m^2]
  const double variance = std::max(least_variance, at.sum.squared_sum / static_cast<double>(at.sum.rows));
  return params_.sigma * params_.sigma / variance * (at.held * at.sum.A * at.held);
}

/// The registration that was taken is the pose, and what holds it is what is known of it.
void ScanMatcher::accept() {
  const Pose& end = last_->end;
  Descent whole = *last_;
  whole.held.setIdentity();
  set_spectrum(result_, measured(whole));
  // A direction that was left as predicted has not been measured (eq. SWP-3), unless the last sweep has held it.
  Mat6 information = measured(*last_);
  if (before_) {
    const Mat6 rest = Mat6::Identity() - last_->held;
    information += rest * measured(*before_) * rest;
  }
  result_.unobservable = last_->degenerate;
  result_.status = last_->degenerate  ? UpdateStatus::degenerate
                   : last_->converged ? UpdateStatus::ok
                                      : UpdateStatus::not_converged;
  if (uses_imu()) {
    state_ = imu_.correct(prior_, end, information);
    twist_.hold(end, state_.t);
  } else {
    twist_.follow(end, state_.t);
    state_.v = end.R * twist_.velocity_in_body();
  }
  state_.R = end.R;
  state_.p = end.p;
  P_.setZero();
  P_.topLeftCorner<6, 6>() = bounded_covariance(information);
  result_.accepted = true;
}

void ScanMatcher::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  result_.insert = status == UpdateStatus::few_matches && twist_.believed(state_.t);
}

const Update& ScanMatcher::update(const Window& window, const HistorySelection&, const StepContext& context) {
  result_ = Update{};
  last_.reset();
  not_finite_ = false;
  propagate(window);
  result_.prior = state_;
  load(window, context);
  const bool map_is_due = (window.sequence - 1) % static_cast<std::uint32_t>(params_.map_every) == 0;
  if (context.map.size() == 0) {
    result_.status = UpdateStatus::initialising;
    twist_.hold(state_.pose(), state_.t);
  } else {
    const bool followed = match_last_sweep();
    const bool matched = map_is_due && match_map(context.map);
    if (not_finite_) {  // whatever else was found: it would hide that
      refuse(UpdateStatus::non_finite);
    } else if (matched || followed) {  // or followed the last sweep alone
      accept();
    } else {
      refuse(UpdateStatus::few_matches);
    }
    result_.insert = result_.insert && (map_is_due || !result_.accepted);
  }
  finish();
  return result_;
}

void ScanMatcher::record_matches() {
  records_.assign(frame_.match_body().size(), MatchRecord{});
  if (!result_.accepted) return;
  double squares = 0;
  std::size_t accepted = 0;
  for (Kind* kind : {&lines_, &planes_}) {
    kind->all.place(state_.pose());
    if (kind->all.surfaces.size() != kind->all.body.size()) continue;  // not matched with the map
    kind->all.evaluate(*kind->residual, params_.sigma);
    double rms = 0;
    const std::size_t own = kind->all.record(kind->rows(), own_records_, rms);
    squares += static_cast<double>(own) * rms * rms;
    accepted += own;
    for (std::size_t i = 0; i < kind->index.size(); ++i) records_[kind->index[i]] = own_records_[i];
  }
  if (accepted > 0) result_.residual_rms = std::sqrt(squares / static_cast<double>(accepted));
}

void ScanMatcher::finish() {
  const CpuTimer timer(result_.times.solve);
  trajectory_.correct(state_.pose());
  frame_.place(trajectory_);
  record_matches();
  if (params_.sweep_searches > 0) {
    for (Kind* kind : {&lines_, &planes_}) kind->last_sweep.build(frame_.world(PointUse::map), kind->feature);
  }
  result_.P = uses_imu() ? imu_.P() : P_;
  hand_over(result_, frame_, records_, state_, {&state_, 1}, trajectory_);
}

}  // namespace aslio::plugins
