#include "estimators/pointwise_eskf.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_matches.hpp"

namespace aslio::plugins {

namespace pw = pointwise;

namespace {

/// A reading this near to the limit of the range may be the limit itself.
constexpr double kNearSaturation = 0.99;

bool saturated(double reading, double limit) { return limit > 0 && std::abs(reading) >= kNearSaturation * limit; }

/// Blocks of the error state that the navigation state has, too: there, here.
constexpr int kCommon[][2] = {{block::theta, pw::theta}, {block::p, pw::p},     {block::v, pw::v},
                              {block::b_w, pw::b_w},     {block::b_a, pw::b_a}, {block::g, pw::g}};

pw::Matrix from_navigation(const StateMatrix& P) {
  pw::Matrix out = pw::Matrix::Zero();
  for (const auto& [row, own_row] : kCommon) {
    for (const auto& [column, own_column] : kCommon) out.block<3, 3>(own_row, own_column) = P.block<3, 3>(row, column);
  }
  return out;
}

StateMatrix to_navigation(const pw::Matrix& P) {
  StateMatrix out = StateMatrix::Zero();
  for (const auto& [row, own_row] : kCommon) {
    for (const auto& [column, own_column] : kCommon) out.block<3, 3>(row, column) = P.block<3, 3>(own_row, own_column);
  }
  return out;
}

}  // namespace

PointwiseEskf::PointwiseEskf(const Params& params, const BuildContext& context)
    : params_(params),
      residual_(params.residual.make(context)),
      frame_(context.sensor),
      means_(params.mean_leaf > 0 ? params.mean_leaf : 1) {}

void PointwiseEskf::reset(const InitialState& initial) {
  state_ = initial.state;
  initial_ = initial;
  velocity_.begin(initial);
  const NavState& s = initial.state;
  now_.x = {s.t, s.R, s.p, s.v, Vec3::Zero(), -(s.R.transpose() * s.g), s.g, s.b_w, s.b_a};
  reset_covariance(initial.sigma_velocity);
  now_.covariance_t = s.t;
  dead_reckoning_.forget();
  result_ = Update{};
}

void PointwiseEskf::adopt(const InertialEstimate& better) {
  better.put(state_);
  now_.x.v = better.v;
  now_.x.b_w = better.b_w;
  now_.x.b_a = better.b_a;
}

/// The covariance of the start.
void PointwiseEskf::reset_covariance(double sigma_velocity) {
  constexpr double rate_variance = 0.01, force_variance = 0.01;
  EstimatedStates estimated;
  estimated.gravity = params_.gravity;
  now_.P = from_navigation(initial_covariance(initial_, estimated, sigma_velocity));
  now_.P.diagonal().segment<3>(pw::w).setConstant(rate_variance);
  now_.P.diagonal().segment<3>(pw::a).setConstant(force_variance);
}

/// eqs. INI-3, PTW-6: the first windows of a start in motion find the velocity alone, against the window before. Points
/// of one direction lie a window apart, so that the end has moved by v T even where the path inside is still wrong: the
/// points are placed anew along an even motion that ends there.
void PointwiseEskf::find_velocity_alone(const PointwiseState& begin) {
  PointwiseState& x = now_.x;
  NavState start = x.nav();
  velocity_.step(plan_, start);
  x.g = start.g;
  x.b_w = start.b_w;
  x.b_a = start.b_a;
  const double duration = to_seconds(x.t - begin.t);
  x.v = (x.p - begin.p) / duration;
  Mat3 turned = Mat3::Identity();
  TimeNs t = begin.t;
  for (const ImuSample& sample : imu_) {
    turned *= exp_so3(to_seconds(sample.t - t) * (sample.gyro - x.b_w));
    t = sample.t;
  }
  PointwiseState even = x;
  even.t = begin.t;
  even.p -= duration * x.v;
  even.R = orthonormalised(x.R * turned.transpose());
  trajectory_.clear();
  states_.clear();
  const auto hold = [&even](const Vec3& w) {
    even.w = w;
    even.a = -(even.R.transpose() * even.g);
  };
  for (const ImuSample& sample : imu_) {
    hold(sample.gyro - x.b_w);
    trajectory_.append({even.t, 0.0, even.R, even.p, even.v, even.w, Vec3::Zero()});
    even.advance(sample.t);
    states_.push_back(even.nav());
  }
  x.w = even.w;
  x.a = -(x.R.transpose() * x.g);
  mark();
  reset_covariance(velocity_.sigma_velocity());
  result_.restart_map = true;
}

NavState PointwiseEskf::predict(std::span<const ImuSample> imu) const {
  PointwiseState x = now_.x;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    x.w = 0.5 * (imu[i - 1].gyro + imu[i].gyro) - x.b_w;
    x.a = 0.5 * (imu[i - 1].acc + imu[i].acc) - x.b_a;
    x.advance(imu[i].t);
  }
  return x.nav();
}

void PointwiseEskf::carry_covariance() {
  if (now_.x.t <= now_.covariance_t) return;
  PointwiseTransition(now_.x, to_seconds(now_.x.t - now_.covariance_t)).apply(params_.noise, now_.P);
  now_.covariance_t = now_.x.t;
}

/// The state goes along with every firing, its covariance with the IMU and from time to time. eq. PTW-4.
void PointwiseEskf::advance(TimeNs t) {
  if (t > now_.x.t) now_.x.advance(t);
  if (to_seconds(t - now_.covariance_t) >= params_.covariance_step) carry_covariance();
}

void PointwiseEskf::correct(const SequentialUpdate& update) {
  const bool unit_gravity = params_.gravity != Gravity::free;
  const Vec3 g = now_.x.g;
  now_.x.add(update.delta(), unit_gravity);
  if (unit_gravity) turn_with_gravity(g, now_.x.g, pw::g, now_.P);
}

void PointwiseEskf::mark() {
  const PointwiseState& x = now_.x;
  trajectory_.append({x.t, 0.0, x.R, x.p, x.v, x.w, x.R * x.a + x.g});
  if (!states_.empty() && states_.back().t == x.t) {
    states_.back() = x.nav();
  } else {
    states_.push_back(x.nav());
  }
}

// eq. PTW-5.
void PointwiseEskf::take_imu(const ImuSample& sample) {
  advance(sample.t);
  carry_covariance();
  SequentialUpdate update(now_.P);
  const bool gyro = (sample.faults & imu_fault::gyro_dead) == 0, acc = (sample.faults & imu_fault::acc_dead) == 0;
  for (int i = 0; i < 3; ++i) {
    const bool gyro_clipped = (sample.faults & imu_fault::clipped(false, i)) != 0;
    const bool acc_clipped = (sample.faults & imu_fault::clipped(true, i)) != 0;
    if (gyro && !gyro_clipped && !saturated(sample.gyro[i], params_.gyro_saturation)) {
      update.sum(pw::w + i, pw::b_w + i, now_.x.w[i] + now_.x.b_w[i] - sample.gyro[i], params_.gyro_variance);
    }
    if (acc && !acc_clipped && !saturated(sample.acc[i], params_.acc_saturation)) {
      update.sum(pw::a + i, pw::b_a + i, now_.x.a[i] + now_.x.b_a[i] - sample.acc[i], params_.acc_variance);
    }
  }
  correct(update);
  mark();
}

/// The points of one firing, matches [begin, end). eq. IESKF-1 with the pose of that moment.
void PointwiseEskf::take_points(std::size_t begin, std::size_t end, const Map& map) {
  advance(frame_.match_time()[begin]);
  const std::size_t n = end - begin, rows_per_match = static_cast<std::size_t>(residual_->rows_per_match());
  world_.resize(n);
  surfaces_.resize(n);
  rows_.resize(n * rows_per_match);
  row_slopes_.resize(rows_.size());
  const auto body = frame_.match_body().subspan(begin, n);
  for (std::size_t i = 0; i < n; ++i) world_[i] = now_.x.R * body[i] + now_.x.p;
  MapQuery query = residual_->query();
  query.viewpoint = frame_.viewpoint({now_.x.R, now_.x.p});
  if (residual_->surfaces_from_map()) {
    map.surfaces(world_, query, surfaces_);
  } else {
    map.correspond(world_, query, neighbours_);
    residual_->fit(world_, neighbours_, surfaces_);
  }
  residual_->evaluate(world_, frame_.match_range().subspan(begin, n), surfaces_, params_.sigma, rows_);

  SequentialUpdate update(now_.P);
  const Mat3 Rt = now_.x.R.transpose();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const ResidualRow& row = rows_[k];
    const Vec3 u_I = Rt * row.J;
    Vec6& h = row_slopes_[k];
    h << body[k / rows_per_match].cross(u_I), row.J;
    if (!row.takes_part()) continue;
    update.pose(h, row.r, 1.0 / row.information);
    information_.noalias() += (row.information * h) * h.transpose();
  }
  correct(update);
  nis_sum_ += update.nis();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    rows_[k].r += row_slopes_[k].dot(update.delta().head<6>());
    if (rows_[k].takes_part()) ++nis_rows_;
  }
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    records_[begin + i] = record_of(std::span(rows_).subspan(i * rows_per_match, rows_per_match), squares);
  }
  mark();
}

/// Between two readings; an axis of which one is at its limit stays there, and is left out as that one is.
ImuSample PointwiseEskf::between(const ImuSample& from, const ImuSample& to, double share) const {
  const auto along = [&](const Vec3& a, const Vec3& b, double limit) {
    Vec3 out;
    for (int i = 0; i < 3; ++i) {
      out[i] = saturated(a[i], limit) ? a[i] : saturated(b[i], limit) ? b[i] : a[i] + share * (b[i] - a[i]);
    }
    return out;
  };
  return {from.t + static_cast<TimeNs>(std::llround(share * static_cast<double>(to.t - from.t))),
          along(from.gyro, to.gyro, params_.gyro_saturation), along(from.acc, to.acc, params_.acc_saturation),
          static_cast<std::uint8_t>(from.faults | to.faults)};
}

/// The window's IMU samples after its begin, with others in between where they are far apart. What was interpolated at
/// its end is no reading unless it is as far from the last: the next reading is the next window's.
void PointwiseEskf::load_imu(const Window& window) {
  imu_.clear();
  const auto imu = window.imu;
  for (std::size_t s = 1; s < imu.size(); ++s) {
    const ImuSample& from = imu[s - 1];
    const ImuSample& to = imu[s];
    const auto parts = static_cast<int>(std::floor(to_seconds(to.t - from.t) / params_.imu_step));
    for (int part = 1; part < parts; ++part) imu_.push_back(between(from, to, static_cast<double>(part) / parts));
    imu_.push_back(to);
  }
  readings_ = imu_.size();
  if (imu_.empty() || window.imu_read_at_end) return;
  const ImuSample& before = imu_.size() > 1 ? imu_[imu_.size() - 2] : imu.front();
  if (to_seconds(imu_.back().t - before.t) < params_.imu_step) {
    --readings_;
  } else {  // one of those in between
    imu_.back() = between(before, imu_.back(), 1.0);
  }
}

/// Points and IMU samples of the window in the order of time; without a map, the IMU alone.
void PointwiseEskf::follow(const Window& window, const Map* map) {
  trajectory_.clear();
  states_.clear();
  mark();
  states_.clear();  // the begin belongs to the window before
  information_.setZero();
  nis_sum_ = 0;
  nis_rows_ = 0;
  const auto times = frame_.match_time();
  records_.assign(times.size(), MatchRecord{});
  std::size_t s = 0, i = map == nullptr ? times.size() : 0;
  while (s < readings_ || i < times.size()) {
    if (i == times.size() || (s < readings_ && imu_[s].t <= times[i])) {
      take_imu(imu_[s++]);
      continue;
    }
    std::size_t next = i + 1;
    while (next < times.size() && times[next] == times[i]) ++next;
    take_points(i, next, *map);
    i = next;
  }
  advance(window.plan.end);
  carry_covariance();
  mark();
}

/// eq. PTW-7.
void PointwiseEskf::sample_means(std::span<const TimedPoint> fresh, SamplerChain& samplers) {
  if (uses_.capacity() < fresh.size()) uses_.reserve(2 * fresh.size());
  uses_.assign(fresh.size(), kAllUses);
  SampleBatch batch{fresh, {}, uses_};
  samplers.sample(Sampler::ActsOn::raw, batch);
  frame_.sample_raw(means_.of(fresh, uses_), no_samplers_);
}

void PointwiseEskf::sample(const Window& window, const StepContext& context) {
  const CpuTimer timer(result_.times.sample);
  const bool all = params_.first_map == FirstMap::all && context.map.size() == 0;
  if (params_.mean_leaf > 0 && !all) {
    sample_means(window.fresh, context.samplers);
  } else {
    frame_.sample_raw(window.fresh, context.samplers);
  }
  frame_.bring_to_imu();
  frame_.sample_body(all ? no_samplers_ : context.samplers);
  if (context.samplers.moves_points() && !all)
    frame_.take_as_measured();  // a mean of points that are not de-skewed is no point
  const std::size_t n = frame_.match_body().size();
  if (records_.capacity() < n) {
    records_.reserve(2 * n);
    states_.reserve(2 * n + 2 * window.imu.size());
    trajectory_.reserve(2 * n + 2 * window.imu.size());
  }
}

const Update& PointwiseEskf::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  result_.history_points = static_cast<std::uint32_t>(past.points.size());
  sample(window, context);
  load_imu(window);
  const Belief before = now_;
  const bool match = context.map.size() > 0;
  {
    const CpuTimer timer(result_.times.predict);
    result_.prior = predict(window.imu);
    result_.prior.t = window.plan.end;
  }
  const CpuTimer timer(result_.times.solve);
  follow(window, match ? &context.map : nullptr);
  const auto accepted = [](const MatchRecord& record) { return record.accepted; };
  const auto matches = std::count_if(records_.begin(), records_.end(), accepted);
  const auto finite = [this] { return now_.x.finite() && now_.P.allFinite(); };
  if (match && matches >= params_.min_matches && finite()) {
    accept(before.x);
  } else {
    const UpdateStatus status = finite() ? UpdateStatus::few_matches : UpdateStatus::non_finite;
    now_ = before;
    follow(window, nullptr);
    if (!finite()) {  // back to the last finite state; the points stay as measured, and nothing is done with them
      now_ = before;
      now_.x.t = now_.covariance_t = window.plan.end;
      trajectory_.clear();
      states_.clear();
      mark();
      refuse(UpdateStatus::non_finite);
    } else if (match) {
      refuse(status);
    } else {
      result_.status = UpdateStatus::initialising;
      dead_reckoning_.begin(now_.x.t, now_.P);
    }
    result_.prior = now_.x.nav();
  }
  finish();
  return result_;
}

void PointwiseEskf::accept(const PointwiseState& begin) {
  result_.accepted = true;
  result_.iterations = 1;
  double squares = 0;
  for (const MatchRecord& record : records_) {
    if (!record.accepted) continue;
    ++result_.fresh_matches;
    squares += static_cast<double>(record.residual) * static_cast<double>(record.residual);
  }
  result_.residual_rms = std::sqrt(squares / result_.fresh_matches);
  result_.nis = nis_sum_ / static_cast<double>(nis_rows_);
  result_.status = UpdateStatus::ok;
  judge_view(result_, information_, params_.degenerate_sigma, plan_);
  if (velocity_.active()) find_velocity_alone(begin);
  dead_reckoning_.begin(now_.x.t, now_.P);
}

void PointwiseEskf::refuse(UpdateStatus status) {
  result_.status = status;
  std::fill(records_.begin(), records_.end(), MatchRecord{});
  result_.insert = status == UpdateStatus::few_matches && dead_reckoning_.good(now_.x.t, now_.P);
}

void PointwiseEskf::finish() {
  state_ = now_.x.nav();
  frame_.place_along(trajectory_);
  result_.P = to_navigation(now_.P);
  hand_over(result_, frame_, records_, state_, states_, trajectory_);
}

}  // namespace aslio::plugins
