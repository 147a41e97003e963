#include "estimators/smoother.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/cpu_clock.hpp"
#include "aslio/toolkit/information_update.hpp"

namespace aslio::plugins {

Smoother::Smoother(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      sensor_(context.sensor),
      motion_(params.motion.make(context)),
      residual_(params.residual.make(context)),
      frame_(context.sensor) {}

void Smoother::reset(const InitialState& initial) {
  initial_ = initial;
  velocity_.begin(initial);
  state_ = initial.state;
  P_ = initial_covariance(initial, params_.estimated, initial.sigma_velocity);
  unresolved_ = {};
  unobservable_ = false;
  dead_reckoning_.forget();
  for (auto& slice : slices_) spare_.push_back(std::move(slice));  // of another time, perhaps a later one
  slices_.clear();
  close();
  result_ = Update{};
}

void Smoother::adopt(const InertialEstimate& better) {
  better.put(state_);
  if (!slices_.empty()) better.put(slices_.back()->state);
  close();  // what the slices so far said of the old ones must not pull back
}

NavState Smoother::predict(std::span<const ImuSample> imu) const {
  NavState state = state_;
  for (std::size_t i = 1; i < imu.size(); ++i) motion_->step(state, imu[i - 1], imu[i]);
  return state;
}

void Smoother::place(Slice& slice) const {
  slice.path.place(slice.points.body, slice.times, slice.points.world, slice.lever, slice.share);
}

/// What all slices match where their paths place the points: those of earlier updates nothing that they or later ones
/// may have put into the map (HIS-1). A plane of the map that several meet is one (RES-5).
void Smoother::associate(const Map& map) {
  const CpuTimer timer(result_.times.associate, result_.times.solve);
  sets_.clear();
  for (std::size_t i = first_; i < slices_.size(); ++i) {
    Slice& slice = *slices_[i];
    place(slice);
    const std::uint32_t max_stamp = i < fresh_ ? slices_[first_]->sequence - 1 : 0xffffffff;
    slice.points.match(map, *residual_, frame_.viewpoint(slice.state.pose()), max_stamp);
    sets_.push_back(slice.points.surfaces);
  }
  if (residual_->counts_shared_matches()) tally_.count(sets_);
}

/// Rows of the points of a slice as they are placed and matched.
void Smoother::measure(Slice& slice) {
  PointMatches& points = slice.points;
  points.evaluate(*residual_, params_.sigma);
  const std::size_t n = points.body.size();
  const auto rows_per_match = static_cast<std::size_t>(residual_->rows_per_match());
  if (partials_.size() < exec::Executor::chunk_count(n, kGrain)) {
    partials_.resize(2 * exec::Executor::chunk_count(n, kGrain));
  }
  slice.sums = exec_.reduce(
      n, kGrain, SliceInformation{}, std::span<SliceInformation>(partials_),
      [&](std::size_t begin, std::size_t end) {
        SliceInformation sum;
        for (std::size_t row = begin * rows_per_match; row < end * rows_per_match; ++row) {
          const ResidualRow& z = points.rows[row];
          if (!z.takes_part()) continue;
          const std::size_t i = row / rows_per_match;
          sum.add(slice.lever[i], slice.share[i], z.J, z.r, z.information);
        }
        return sum;
      },
      [](SliceInformation& total, const SliceInformation& part) { total += part; });
}

/// eq. SMO-2 about the iterate.
void Smoother::linearise(std::size_t i, SliceEquations& out) const {
  const Slice& slice = *slices_[i];
  NavState state = begin_of(i);
  out.F.setIdentity();
  out.Q.setZero();
  StateMatrix F;
  Eigen::Matrix<double, kStateDim, 12> G;
  for (std::size_t s = 1; s < slice.imu.size(); ++s) {
    const ImuSample &from = slice.imu[s - 1], &to = slice.imu[s];
    motion_->linearise(state, from, to, F, G);
    out.F = (F * out.F).eval();
    motion_->propagate_covariance(state, from, to, params_.noise.over(from, to, sensor_, state.b_w, slice.noise_of),
                                  out.Q);
    walk_gravity(params_.estimated, belief_.g, to_seconds(to.t - from.t), out.Q);
    motion_->step(state, from, to);
  }
  out.d = box_minus(slice.state, slice.path.predicted());
  const Vec3 missed = out.d.segment<3>(block::theta);
  out.F.topRows<3>() = (exp_so3(-missed) * out.F.topRows<3>()).eval();
  out.Q = transported_covariance(out.Q, missed);
  slice.sums.tell(begin_of(i).R, slice.state.R, out);
}

/// One step of all states; false when it is not finite.
bool Smoother::step(double& turn, double& shift) {
  const std::size_t n = slices_.size() - first_;
  if (equations_.size() < n) equations_.resize(n);
  for (std::size_t i = 0; i < n; ++i) linearise(first_ + i, equations_[i]);
  const StateVector off = box_minus(begin_, belief_);
  pass_.run({-off, transported_covariance(belief_P_, off.head<3>())}, equations_, n);

  const bool unit_gravity = params_.estimated.gravity != Gravity::free;
  turn = shift = 0;
  const auto move = [&](NavState& x, const StateVector& by) {
    turn = std::max(turn, by.segment<3>(block::theta).norm());
    shift = std::max(shift, by.segment<3>(block::p).norm());
    x = box_plus(x, by, unit_gravity);
  };
  for (std::size_t i = 0; i < n; ++i) {
    Slice& slice = *slices_[first_ + i];
    const ErrorBelief& known = pass_.filtered(i);
    if (!pass_.end(i).allFinite() || !known.P.allFinite() || known.P.diagonal().minCoeff() < -1e-12) return false;
    slice.filtered = box_plus(slice.state, known.mean, unit_gravity);
    slice.P = transported_covariance(known.P, known.mean.head<3>());
    if (unit_gravity) turn_with_gravity(belief_.g, slice.filtered.g, block::g, slice.P);
    move(slice.state, pass_.end(i));
  }
  move(begin_, pass_.begin());
  return begin_.p.allFinite() && begin_.R.allFinite();
}

SliceInformation Smoother::fresh_sums() const {
  SliceInformation sum;
  for (std::size_t i = fresh_; i < slices_.size(); ++i) sum += slices_[i]->sums;
  return sum;
}

/// Of all slices and of the fresh ones; returns the rows of the latter, of which a match may have several.
std::size_t Smoother::count_matches() {
  const auto rows_per_match = static_cast<std::size_t>(residual_->rows_per_match());
  std::size_t old = 0, fresh = 0;
  for (std::size_t i = first_; i < slices_.size(); ++i) {
    const Slice& slice = *slices_[i];
    (i < fresh_ ? old : fresh) += aslio::count_matches(slice.points.rows, rows_per_match, slice.sums.accepted);
  }
  result_.fresh_matches = static_cast<std::uint32_t>(fresh);
  result_.history_matches = static_cast<std::uint32_t>(old);
  return fresh_sums().accepted;
}

void Smoother::iterate(const StepContext& context) {
  const CpuTimer timer(result_.times.solve);
  for (int j = 0; j < params_.max_iterations; ++j) {
    if (j > 0) trace_all();
    associate(context.map);
    for (std::size_t i = first_; i < slices_.size(); ++i) measure(*slices_[i]);
    result_.iterations = j + 1;
    const std::size_t rows = count_matches();
    if (static_cast<std::int64_t>(result_.fresh_matches) < params_.min_matches) {
      return refuse(UpdateStatus::few_matches);
    }
    double turn = 0, shift = 0;
    if (!step(turn, shift)) return refuse(UpdateStatus::non_finite);
    if (j == 0) {
      double squares = 0;
      for (std::size_t i = fresh_; i < slices_.size(); ++i) squares += pass_.squared_innovation(i - first_);
      result_.nis = squares / static_cast<double>(rows);
    }
    const double enough_turn = params_.converged_deg * kRadPerDeg, enough_shift = params_.converged_m;
    const bool converged = turn < enough_turn && shift < enough_shift;
    if (!converged && j + 1 < params_.max_iterations) continue;
    result_.status = status_of_last_step(settled(turn, enough_turn) && settled(shift, enough_shift));
    return accept();
  }
}

void Smoother::accept() {
  const SliceInformation fresh = fresh_sums();
  state_ = slices_.back()->state;
  P_ = slices_.back()->P;
  Mat6 into = Mat6::Identity();
  into.topLeftCorner<3, 3>() = state_.R;
  judge_view(result_, into.transpose() * fresh.A0 * into, params_.degenerate_sigma, plan_);
  unobservable_ = result_.unobservable;
  result_.accepted = true;
  trace_all();
  if (velocity_.active()) find_velocity_alone();
  dead_reckoning_.begin(state_.t, P_);
}

/// eq. INI-3: the first windows were de-skewed with a wrong velocity; their displacements must not pass for
/// acceleration.
void Smoother::find_velocity_alone() {
  velocity_.step(plan_, state_);
  P_ = initial_covariance(initial_, params_.estimated, velocity_.sigma_velocity());
  result_.restart_map = true;
}

/// The iterates as they were before this update, the fresh slices as predicted.
void Smoother::restore() {
  begin_ = before_.front();
  for (std::size_t i = first_; i < slices_.size(); ++i) slices_[i]->state = before_[i - first_ + 1];
  trace_all();
}

void Smoother::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  restore();
  predict_covariance();
  state_ = slices_.back()->state;
  unobservable_ = dead_reckoning_.begun();
  result_.insert = status == UpdateStatus::few_matches && dead_reckoning_.good(state_.t, P_);
}

const Update& Smoother::update(const Window& window, const HistorySelection&, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  const bool predicted = propagate(window);
  if (!predicted) stand_still(window.plan.end);
  before_.assign(1, begin_);
  for (std::size_t i = first_; i < slices_.size(); ++i) before_.push_back(slices_[i]->state);
  result_.prior = slices_.back()->state;
  frame_.load(window.fresh, carried_, context.samplers, result_.times);
  frame_.take_as_measured();
  hand_out_points();
  if (!predicted) {
    result_.status = UpdateStatus::non_finite;
    result_.insert = false;
    unobservable_ = dead_reckoning_.begun();
  } else if (context.map.size() == 0) {
    predict_covariance();
    state_ = slices_.back()->state;
    result_.status = UpdateStatus::initialising;
    dead_reckoning_.begin(state_.t, P_);
  } else {
    iterate(context);
  }
  finish();
  if (!result_.accepted || result_.restart_map) close();
  return result_;
}

/// Where the path of its slice has moved it since.
Vec3 Smoother::place(const WorldPoint& point) const {
  const auto slice = std::find_if(slices_.begin(), slices_.end(),
                                  [&](const auto& candidate) { return point.t <= candidate->state.t; });
  if (slice == slices_.end() || point.t <= (*slice)->placed.begin().t) return point.p_W;
  return (*slice)->path.pose(point.t) * ((*slice)->placed.pose(point.t).inverse() * point.p_W);
}

/// What the last matches of the fresh points are off by at the smoothed states.
void Smoother::record_matches() {
  double squares = 0;
  std::size_t all = 0;
  for (std::size_t i = fresh_; i < slices_.size(); ++i) {
    Slice& slice = *slices_[i];
    place(slice);
    measure(slice);
    double rms = 0;
    const std::size_t accepted =
        slice.points.record(static_cast<std::size_t>(residual_->rows_per_match()), slice_records_, rms);
    records_.insert(records_.end(), slice_records_.begin(), slice_records_.end());
    squares += rms * rms * static_cast<double>(accepted);
    all += accepted;
  }
  if (all > 0) result_.residual_rms = std::sqrt(squares / static_cast<double>(all));
}

void Smoother::finish() {
  const CpuTimer timer(result_.times.solve);
  records_.clear();
  states_.clear();
  chain_.clear();
  for (std::size_t i = fresh_; i < slices_.size(); ++i) {
    chain_.append(slices_[i]->path);
    slices_[i]->path.list_states(states_);
  }
  if (result_.accepted) {
    record_matches();
    if (slices_.size() - fresh_ == 1 && !residual_->surfaces_from_map()) {
      result_.neighbours = &slices_.back()->points.neighbours;
    }
  } else {
    records_.assign(frame_.match_body().size(), MatchRecord{});
  }
  for (std::size_t i = fresh_; i < slices_.size(); ++i) slices_[i]->placed = slices_[i]->path;
  frame_.place_along(chain_);
  states_.back() = state_;
  result_.P = P_;
  result_.revision = this;
  hand_over(result_, frame_, records_, state_, states_, chain_);
}

}  // namespace aslio::plugins
