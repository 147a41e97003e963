// The slices of a smoother: how a window is cut into them, and their paths.
#include <algorithm>
#include <cmath>

#include "aslio/core/cpu_clock.hpp"
#include "estimators/smoother.hpp"

namespace aslio::plugins {

namespace {

bool finite(const NavState& x) {
  return x.R.allFinite() && x.p.allFinite() && x.v.allFinite() && x.b_w.allFinite() && x.b_a.allFinite() &&
         x.g.allFinite() && x.S_w.allFinite() && std::isfinite(x.imu_delay);
}

ImuSample between(const ImuSample& from, const ImuSample& to, TimeNs t) {
  const double share = static_cast<double>(t - from.t) / static_cast<double>(to.t - from.t);
  return {t, from.gyro + share * (to.gyro - from.gyro), from.acc + share * (to.acc - from.acc)};
}

}  // namespace

/// eq. SMO-4: what ends before the window stays as a belief of its end.
void Smoother::leave(TimeNs history_begin) {
  std::size_t gone = 0;
  while (gone < slices_.size() && slices_[gone]->state.t <= history_begin) ++gone;
  if (gone > first_) {
    const Slice& last = *slices_[gone - 1];
    belief_ = last.filtered;
    belief_P_ = last.P;
    begin_ = last.state;
  }
  first_ -= std::min(first_, gone);
  for (std::size_t i = 0; i < gone; ++i) spare_.push_back(std::move(slices_[i]));
  slices_.erase(slices_.begin(), slices_.begin() + static_cast<std::ptrdiff_t>(gone));
}

/// All that is known becomes a belief of the present, and the chain begins anew: slices so far stay where they are.
void Smoother::close() {
  first_ = slices_.size();
  belief_ = begin_ = state_;
  belief_P_ = P_;
}

Smoother::Slice& Smoother::add_slice() {
  if (spare_.empty()) spare_.push_back(std::make_unique<Slice>());
  slices_.push_back(std::move(spare_.back()));
  spare_.pop_back();
  Slice& slice = *slices_.back();
  slice.imu.clear();
  slice.points.body.clear();
  slice.points.range.clear();
  slice.times.clear();
  slice.sums = {};
  slice.noise_of = {unobservable_, 0, unresolved_.density()};
  return slice;
}

/// A slice per part of the window, with the IMU samples that cover it.
void Smoother::cut(const Window& window) {
  fresh_ = slices_.size();
  unresolved_.observe(window);
  const std::span<const TimeNs> named(window.plan.cuts.data(), window.plan.cut_count);
  const std::span<const TimeNs> ends = named.empty() ? std::span<const TimeNs>(&window.plan.end, 1) : named;
  std::size_t next = 0;
  for (const TimeNs end : ends) {
    Slice& slice = add_slice();
    slice.sequence = window.sequence;
    slice.noise_of.imu_gap = window.imu_gap;
    if (next > 0) slice.imu.push_back(slices_[slices_.size() - 2]->imu.back());
    while (next < window.imu.size() && window.imu[next].t <= end) slice.imu.push_back(window.imu[next++]);
    if (next > 0 && next < window.imu.size() && slice.imu.back().t < end) {
      slice.imu.push_back(between(window.imu[next - 1], window.imu[next], end));
    }
    slice.state.t = end;
  }
}

/// The path of a slice with the IMU read as its begin has it; returns the end that this predicts.
NavState Smoother::trace(Slice& slice, const NavState& begin) const {
  const TimeNs end = slice.state.t;
  NavState state = begin;
  slice.path.clear(begin, end);
  for (std::size_t i = 1; i < slice.imu.size(); ++i) {
    const MotionSegment segment = motion_->step(state, slice.imu[i - 1], slice.imu[i]);
    slice.path.append(segment, state);
  }
  state.t = end;
  return state;
}

void Smoother::trace_all() {
  for (std::size_t i = first_; i < slices_.size(); ++i) {
    trace(*slices_[i], begin_of(i));
    slices_[i]->path.meet(slices_[i]->state);
  }
}

/// Adds the slices of the window as the IMU predicts them; false when that is not finite.
bool Smoother::propagate(const Window& window) {
  const CpuTimer timer(result_.times.predict);
  leave(window.plan.history_begin);
  cut(window);
  for (std::size_t i = fresh_; i < slices_.size(); ++i) {
    Slice& slice = *slices_[i];
    slice.state = trace(slice, begin_of(i));
    slice.path.meet(slice.state);
    if (!finite(slice.state)) return false;
  }
  NavState state = state_;  // for the samplers, which see the points at the end of the window
  carried_.clear(state);
  for (std::size_t i = 1; i < window.imu.size(); ++i) {
    const MotionSegment segment = motion_->step(state, window.imu[i - 1], window.imu[i]);
    carried_.append(segment, state);
  }
  return true;
}

/// In place of a prediction that is not finite: back to the last state; the points stay as measured, and nothing is
/// done with them.
void Smoother::stand_still(TimeNs end) {
  for (std::size_t i = fresh_; i < slices_.size(); ++i) spare_.push_back(std::move(slices_[i]));
  slices_.resize(fresh_);
  state_.t = end;
  close();
  Slice& slice = add_slice();
  slice.state = state_;
  slice.path.clear(state_, end);
  carried_.clear(state_);
}

/// P_ goes with the prediction of a window whose points tell nothing.
void Smoother::predict_covariance() {
  const StateMatrix before = P_;
  for (std::size_t s = fresh_; s < slices_.size(); ++s) {
    const Slice& slice = *slices_[s];
    NavState state = s == fresh_ ? state_ : slices_[s - 1]->state;
    for (std::size_t i = 1; i < slice.imu.size(); ++i) {
      const ImuSample &from = slice.imu[i - 1], &to = slice.imu[i];
      motion_->propagate_covariance(state, from, to, params_.noise.over(from, to, sensor_, state.b_w, slice.noise_of),
                                    P_);
      walk_gravity(params_.estimated, state.g, to_seconds(to.t - from.t), P_);
      motion_->step(state, from, to);
    }
  }
  P_ = P_.allFinite() ? (0.5 * (P_ + P_.transpose())).eval() : before;
}

/// The points of the match use to the slices that measured them, as measured.
void Smoother::hand_out_points() {
  const auto body = frame_.match_body();
  const auto range = frame_.match_range();
  const auto times = frame_.match_time();
  std::size_t begin = 0;
  for (std::size_t s = fresh_; s < slices_.size(); ++s) {
    Slice& slice = *slices_[s];
    std::size_t end = begin;
    while (end < times.size() && (times[end] <= slice.state.t || s + 1 == slices_.size())) ++end;
    const std::size_t n = end - begin;
    if (slice.times.capacity() < n) {
      slice.points.reserve(n, *residual_);
      slice.times.reserve(2 * n);
      slice.lever.reserve(2 * n);
      slice.share.reserve(2 * n);
    }
    slice.points.body.assign(body.begin() + static_cast<std::ptrdiff_t>(begin),
                             body.begin() + static_cast<std::ptrdiff_t>(end));
    slice.points.range.assign(range.begin() + static_cast<std::ptrdiff_t>(begin),
                              range.begin() + static_cast<std::ptrdiff_t>(end));
    slice.times.assign(times.begin() + static_cast<std::ptrdiff_t>(begin),
                       times.begin() + static_cast<std::ptrdiff_t>(end));
    slice.lever.resize(n);
    slice.share.resize(n);
    slice.points.world.resize(n);
    begin = end;
  }
}

}  // namespace aslio::plugins
