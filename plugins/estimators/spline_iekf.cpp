#include "estimators/spline_iekf.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "estimators/pointwise_state.hpp"

namespace aslio::plugins {

namespace sp = spline;

namespace {

/// Axes (1, 2, 4 of x, y, z) that read something.
unsigned reading_axes(const ImuSample& sample, bool acc) {
  if ((sample.faults & (acc ? imu_fault::acc_dead : imu_fault::gyro_dead)) != 0) return 0;
  unsigned axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if ((sample.faults & imu_fault::clipped(acc, axis)) == 0) axes |= 1U << axis;
  }
  return axes;
}

/// P of NavState, and nothing known of the rate but `rate_variance`.
sp::MomentMatrix moment_covariance(const StateMatrix& P, double rate_variance) {
  static constexpr int kCommon[][2] = {{block::theta, sp::moment::theta}, {block::p, sp::moment::p},
                                       {block::v, sp::moment::v},         {block::b_w, sp::moment::b_w},
                                       {block::b_a, sp::moment::b_a},     {block::g, sp::moment::g}};
  sp::MomentMatrix out = sp::MomentMatrix::Zero();
  for (const auto& [row, own_row] : kCommon) {
    for (const auto& [column, own_column] : kCommon) out.block<3, 3>(own_row, own_column) = P.block<3, 3>(row, column);
  }
  out.diagonal().segment<3>(sp::moment::w).setConstant(rate_variance);
  return out;
}

}  // namespace

SplineIekf::SplineIekf(const Params& params, const BuildContext& context)
    : params_(params), residual_(params.residual.make(context)), frame_(context.sensor) {
  if (!params_.imu) params_.noise.gyro_bias = params_.noise.acc_bias = 0;  // there is nothing that has one
  constexpr std::size_t knots = 256;                                       // of a window without a gap
  trajectory_.reserve(knots);
  states_.reserve(knots);
}

void SplineIekf::reset(const InitialState& initial) {
  state_ = initial.state;
  initial_ = initial;
  velocity_.begin(initial);
  const NavState& s = initial.state;
  SplineState& x = now_.x;
  x.interval = to_ns(params_.interval);
  x.b_w = s.b_w;
  x.b_a = s.b_a;
  x.g = s.g;
  x.set(s.t, s.pose(), s.v, initial.rate);
  reset_covariance(initial.sigma_velocity);
  dead_reckoning_.forget();
  twist_ = {};
  twist_.begin(initial.rate, s.R.transpose() * s.v);
  result_ = Update{};
}

/// The covariance of the start, about state_.
void SplineIekf::reset_covariance(double sigma_velocity) {
  constexpr double rate_variance = 0.01;
  EstimatedStates estimated;
  estimated.gravity = params_.gravity;
  StateMatrix P = initial_covariance(initial_, estimated, sigma_velocity);
  if (!params_.imu) {  // nothing measures them
    for (const int of : {block::b_w, block::b_a, block::g}) {
      P.middleRows<3>(of).setZero();
      P.middleCols<3>(of).setZero();
    }
  }
  now_.spread(state_.t, moment_covariance(P, rate_variance), params_.noise);
}

void SplineIekf::adopt(const InertialEstimate& better) {
  if (params_.imu) {
    now_.x.change_velocity(state_.t, better.v - state_.v);
    now_.x.b_w = better.b_w;
    now_.x.b_a = better.b_a;
  }
  better.put(state_);
}

void SplineIekf::set_noise_scale(double scale) {
  noise_scale_ = scale;
  residual_->set_noise_scale(scale);
}

void SplineIekf::doubt_gyro_bias(double sigma) {
  if (params_.imu) now_.P.diagonal().segment<3>(sp::b_w).array() += sigma * sigma;
}

NavState SplineIekf::predict(std::span<const ImuSample> imu) const {
  if (!params_.imu) return imu.empty() ? state_ : twist_.predict(state_, imu.back().t);
  const NavState& s = state_;
  PointwiseState x{s.t, s.R, s.p, s.v, Vec3::Zero(), Vec3::Zero(), s.g, s.b_w, s.b_a};
  for (std::size_t i = 1; i < imu.size(); ++i) {
    x.w = 0.5 * (imu[i - 1].gyro + imu[i].gyro) - x.b_w;
    x.a = 0.5 * (imu[i - 1].acc + imu[i].acc) - x.b_a;
    x.advance(imu[i].t);
  }
  return x.nav();
}

void SplineIekf::sample(const Window& window, const StepContext& context) {
  const CpuTimer timer(result_.times.sample);
  frame_.sample_raw(window.fresh, context.samplers);
  frame_.bring_to_imu();
  frame_.sample_body(context.samplers);
  if (context.samplers.moves_points()) frame_.take_as_measured();  // a mean of points not de-skewed is no point
  const std::size_t n = frame_.match_body().size();
  if (records_.capacity() < n) records_.reserve(2 * n);
  batch_.reserve(std::min(n, static_cast<std::size_t>(params_.batch_points)), *residual_);
}

/// From the next IMU sample and point on, all that lies within the segment, up to `batch_points`.
SplineIekf::Batch SplineIekf::next_batch(std::size_t imu, std::size_t point, std::size_t points) const {
  const auto times = frame_.match_time();
  const TimeNs until = now_.x.end();
  Batch out{imu, imu, point, point};
  const auto most = static_cast<std::size_t>(params_.batch_points);
  while (out.points_end < points && times[out.points_end] <= until && out.points() < most) ++out.points_end;
  // Not beyond the next point, which is of the next update.
  const TimeNs last = out.points_end < points && times[out.points_end] <= until ? times[out.points_end] : until;
  while (out.imu_end < imu_.size() && imu_[out.imu_end].t <= last) ++out.imu_end;
  return out;
}

/// Until the segment holds t.
void SplineIekf::advance(TimeNs t) {
  while (t > now_.x.end()) {
    now_.advance(t, params_.noise);
    trajectory_.follow(now_.x);
  }
}

/// Points and IMU samples of the window, one segment after the other; without a map, the IMU alone. False when the
/// state is no longer finite.
bool SplineIekf::follow(const Window& window, const Map* map) {
  trajectory_.begin(now_.x);
  information_.setZero();
  nis_sum_ = 0;
  nis_rows_ = 0;
  iterations_ = 0;
  const auto times = frame_.match_time();
  records_.assign(times.size(), MatchRecord{});
  const std::size_t points = map == nullptr ? 0 : times.size();
  std::size_t s = 0, i = 0;
  while (s < imu_.size() || i < points) {
    const TimeNs next = i == points || (s < imu_.size() && imu_[s].t <= times[i]) ? imu_[s].t : times[i];
    advance(next);
    const Batch batch = next_batch(s, i, points);
    if (!take(batch, map)) return false;
    trajectory_.follow(now_.x);
    s = batch.imu_end;
    i = batch.points_end;
  }
  advance(window.plan.end);
  trajectory_.close(window.plan.end);
  return now_.x.finite() && now_.P.allFinite();
}

void SplineIekf::place(const Batch& batch, const CubicSplineSegment& segment) {
  batch_.world.resize(batch.points());
  const auto times = frame_.match_time();
  for (std::size_t k = 0; k < batch.points(); ++k) {
    batch_.world[k] = segment.pose(now_.x.share(times[batch.points_begin + k])) * batch_.body[k];
  }
}

void SplineIekf::match(const Batch& batch, const CubicSplineSegment& segment, const Map& map) {
  const CpuTimer timer(result_.times.associate, result_.times.solve);
  place(batch, segment);
  const double middle = now_.x.share(frame_.match_time()[(batch.points_begin + batch.points_end) / 2]);
  batch_.match(map, *residual_, frame_.viewpoint(segment.pose(middle)), 0xffffffff);
}

/// `pose`: what the points know of the pose of their own moments.
SplineInformation SplineIekf::measure_points(const Batch& batch, const CubicSplineSegment& segment, Mat6& pose) {
  batch_.evaluate(*residual_, params_.sigma * noise_scale_);
  SplineInformation out;
  const auto times = frame_.match_time();
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  pose.setZero();
  TimeNs seen = kTimeMin;  // points of one firing share its slopes
  SplineSlopes slopes;
  Mat3 R;
  for (std::size_t k = 0; k < batch.points(); ++k) {
    const TimeNs t = times[batch.points_begin + k];
    if (t != seen) {
      slopes = segment.slopes(now_.x.share(t));
      R = segment.pose(now_.x.share(t)).R;
      seen = t;
    }
    for (const ResidualRow& row : std::span<const ResidualRow>(batch_.rows).subspan(k * rows, rows)) {
      if (!row.takes_part()) continue;
      const Vec6 h = out.add_point(slopes, R, batch_.body[k], row.J, row.r, row.information);
      pose.noalias() += (row.information * h) * h.transpose();
    }
  }
  return out;
}

// eq. SPL-7.
void SplineIekf::measure_imu(const Batch& batch, const CubicSplineSegment& segment,
                             SplineInformation& information) const {
  for (std::size_t s = batch.imu_begin; s < batch.imu_end; ++s) {
    const ImuSample& sample = imu_[s];
    const double u = now_.x.share(sample.t);
    const SplineMoment at = segment.at(u);
    const SplineSlopes slopes = segment.slopes(u);
    information.add_gyro(at, slopes, now_.x, sample, reading_axes(sample, false), params_.gyro_variance);
    information.add_acc(at, slopes, now_.x, sample, reading_axes(sample, true), params_.acc_variance);
  }
}

/// One update of the iterated filter. eq. SPL-8. False when it left the finite numbers.
bool SplineIekf::take(const Batch& batch, const Map* map) {
  const SplineState prior = now_.x;
  const auto body = frame_.match_body().subspan(batch.points_begin, batch.points());
  const auto range = frame_.match_range().subspan(batch.points_begin, batch.points());
  batch_.body.assign(body.begin(), body.end());
  batch_.range.assign(range.begin(), range.end());
  sp::Matrix P = now_.P;
  Mat6 pose = Mat6::Zero();
  for (std::int64_t j = 0; j < params_.max_iterations; ++j) {
    const CubicSplineSegment segment = now_.x.segment();
    SplineInformation information;
    if (batch.points() > 0) {
      match(batch, segment, *map);
      information = measure_points(batch, segment, pose);
    }
    if (j == 0 && information.rows > 0) {
      nis_sum_ += squared_innovation(now_.P, information);
      nis_rows_ += information.rows;
    }
    measure_imu(batch, segment, information);
    const SplineStep step(now_.P, now_.x.minus(prior), information);
    if (!step.delta.allFinite() || !step.P.allFinite()) return false;
    now_.x.add(step.delta, params_.gravity != Gravity::free);
    P = step.P;
    iterations_ = std::max(iterations_, j + 1);
    if (step.delta.head<sp::kControl>().lpNorm<Eigen::Infinity>() < params_.converged) break;
  }
  now_.P = P;
  if (params_.gravity != Gravity::free) turn_with_gravity(prior.g, now_.x.g, sp::g, now_.P);
  information_ += pose;
  if (batch.points() > 0) record(batch, now_.x.segment());
  return true;
}

/// What became of the matches of the batch, at its posterior.
void SplineIekf::record(const Batch& batch, const CubicSplineSegment& segment) {
  place(batch, segment);
  batch_.evaluate(*residual_, params_.sigma * noise_scale_);
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  for (std::size_t k = 0; k < batch.points(); ++k) {
    double squares = 0;
    records_[batch.points_begin + k] =
        record_of(std::span<const ResidualRow>(batch_.rows).subspan(k * rows, rows), squares);
  }
}

const Update& SplineIekf::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  result_.history_points = static_cast<std::uint32_t>(past.points.size());
  sample(window, context);
  imu_ = params_.imu ? window.imu : std::span<const ImuSample>{};
  if (!imu_.empty()) imu_ = imu_.subspan(1);  // the first is the last of the window before, or interpolated
  if (!imu_.empty() && !window.imu_read_at_end) imu_ = imu_.first(imu_.size() - 1);
  const SplineBelief before = now_;
  const NavState begin = state_;
  const bool match = context.map.size() > 0;
  {
    const CpuTimer timer(result_.times.predict);
    const ImuSample end{.t = window.plan.end};
    result_.prior = predict(params_.imu ? window.imu : std::span<const ImuSample>(&end, 1));
    result_.prior.t = window.plan.end;
  }
  const CpuTimer timer(result_.times.solve);
  bool finite = follow(window, match ? &context.map : nullptr);
  const auto matches =
      std::count_if(records_.begin(), records_.end(), [](const MatchRecord& record) { return record.accepted; });
  if (match && finite && matches >= params_.min_matches) {
    accept(begin);
  } else {
    const UpdateStatus status = finite ? UpdateStatus::few_matches : UpdateStatus::non_finite;
    now_ = before;
    finite = follow(window, nullptr);
    if (!finite) {
      now_ = before;
      stay(window.plan.end);
    }
    if (match || !finite) {
      refuse(finite ? status : UpdateStatus::non_finite);
    } else {
      result_.status = UpdateStatus::initialising;
    }
    result_.prior = now_.x.nav(window.plan.end);
  }
  finish();
  return result_;
}

/// The state as it was, at t.
void SplineIekf::stay(TimeNs t) {
  now_.x.begin += t - state_.t;
  trajectory_.begin(now_.x);
  trajectory_.close(t);
}

void SplineIekf::accept(const NavState& begin) {
  result_.accepted = true;
  result_.iterations = static_cast<int>(iterations_);
  double squares = 0;
  for (const MatchRecord& record : records_) {
    if (!record.accepted) continue;
    ++result_.fresh_matches;
    squares += static_cast<double>(record.residual) * static_cast<double>(record.residual);
  }
  result_.residual_rms = std::sqrt(squares / result_.fresh_matches);
  result_.nis = nis_rows_ > 0 ? nis_sum_ / static_cast<double>(nis_rows_) : 0.0;
  result_.status = UpdateStatus::ok;
  judge_view(result_, information_, params_.degenerate_sigma, plan_);
  if (velocity_.active() && params_.imu) find_velocity_alone(begin);
}

/// eqs. INI-3, SPL-10: the first windows of a start in motion find the velocity alone, against the window before.
void SplineIekf::find_velocity_alone(const NavState& begin) {
  SplineState& x = now_.x;
  NavState end = x.nav(plan_.end);
  velocity_.step(plan_, end);
  x.b_w = end.b_w;
  x.b_a = end.b_a;
  x.g = end.g;
  const Vec3 v = (end.p - begin.p) / to_seconds(plan_.end - begin.t);
  const Vec3 w = x.moment(plan_.end).w;
  trajectory_.straighten(v);
  x.set(plan_.end, end.pose(), v, w);
  state_ = x.nav(plan_.end);
  reset_covariance(velocity_.sigma_velocity());
  result_.restart_map = true;
}

void SplineIekf::refuse(UpdateStatus status) {
  result_.status = status;
  std::fill(records_.begin(), records_.end(), MatchRecord{});
  const bool good =
      params_.imu ? dead_reckoning_.good(plan_.end, now_.nav_covariance(plan_.end)) : twist_.believed(plan_.end);
  result_.insert = status == UpdateStatus::few_matches && good;
}

void SplineIekf::finish() {
  const TimeNs end = plan_.end;
  const SplineMoment at = now_.x.moment(end);
  const NavState before = state_;
  state_ = now_.x.nav(end);
  state_.S_w = before.S_w;
  state_.imu_delay = before.imu_delay;
  result_.P = now_.nav_covariance(end);
  if (result_.accepted || result_.status == UpdateStatus::initialising) {
    dead_reckoning_.begin(end, result_.P);
    twist_.begin(at.w, at.R.transpose() * at.v);
    twist_.hold(state_.pose(), end);
  }
  states_.clear();
  for (std::size_t k = 0; k < trajectory_.segments(); ++k) {
    const TimeNs t = trajectory_.begin_of(k);
    if (t <= before.t || t >= end) continue;
    const SplineMoment knot = trajectory_.moment(t);
    NavState& inside = states_.emplace_back(state_);
    inside.t = t;
    inside.R = orthonormalised(knot.R);
    inside.p = knot.p;
    inside.v = knot.v;
  }
  states_.push_back(state_);
  frame_.place_along(trajectory_);
  hand_over(result_, frame_, records_, state_, states_, trajectory_);
}

}  // namespace aslio::plugins
