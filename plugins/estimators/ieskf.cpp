#include "estimators/ieskf.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aslio/core/angles.hpp"
#include "aslio/core/cpu_clock.hpp"
#include "aslio/toolkit/point_matches.hpp"

namespace aslio::plugins {

Ieskf::Ieskf(const Params& params, const BuildContext& context)
    : params_(params),
      sigma_(params.sigma),
      exec_(context.exec),
      sensor_(context.sensor),
      motion_(params.motion.make(context)),
      residual_(params.residual.make(context)),
      sensors_(params.sensors, context.sensor),
      path_(params.deskew_correction == DeskewCorrection::linear ||
                    params.deskew_correction == DeskewCorrection::asymptotic
                ? WindowTrajectory::Spread::linear
                : WindowTrajectory::Spread::rigid),
      frame_(context.sensor),
      directions_(params.directional) {}

void Ieskf::reset(const InitialState& initial) {
  initial_ = initial;
  velocity_.begin(initial);
  state_ = initial.state;
  P_ = start_covariance(initial.sigma_velocity);
  sensors_.reset(initial.mode == InitialMode::static_start);
  frame_.set_extrinsic(sensors_.T_imu_lidar());
  sensors_.start_map(state_, params_.estimated.gravity != Gravity::fixed, P_);
  dead_reckoning_.forget();
  unresolved_ = {};
  unobservable_ = false;
  result_ = Update{};
}

/// eqs. INI-4, INI-8.
StateMatrix Ieskf::start_covariance(double sigma_velocity) const {
  StateMatrix P = initial_covariance(initial_, params_.estimated, sigma_velocity);
  if (params_.start_covariance == StartCovariance::measured) return P;
  constexpr double motion = 1.0, gyro_bias = 1e-4, acc_bias = 1e-3, gravity_direction = 1e-5;
  for (const int at : {block::theta, block::p, block::v}) P.diagonal().segment<3>(at).setConstant(motion);
  P.diagonal().segment<3>(block::b_w).setConstant(gyro_bias);
  P.diagonal().segment<3>(block::b_a).setConstant(acc_bias);
  if (params_.estimated.gravity != Gravity::fixed) {
    const Vec3& g = initial_.state.g;
    P.block<3, 3>(block::g, block::g) = gravity_direction * (g.squaredNorm() * Mat3::Identity() - g * g.transpose());
  }
  return P;
}

NavState Ieskf::predict(std::span<const ImuSample> imu) const {
  NavState state = state_;
  for (std::size_t i = 1; i < imu.size(); ++i) motion_->step(state, sensors_.read(imu[i - 1]), sensors_.read(imu[i]));
  return state;
}

void Ieskf::propagate(const Window& window) {
  const CpuTimer timer(result_.times.predict);
  NavState state = state_;
  const std::span<const ImuSample> imu = sensors_.read(window.imu);
  path_.start(state, imu);
  unresolved_.observe(window);
  Eigen::Matrix<double, 3, kStateDim> turned = Eigen::Matrix<double, 3, kStateDim>::Zero();
  StateMatrix F;
  Eigen::Matrix<double, kStateDim, 12> G;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    const ImuSample& from = imu[i - 1];
    const ImuSample& to = imu[i];
    if (params_.deskew_correction == DeskewCorrection::state || sensors_.active()) {
      motion_->linearise(state, from, to, F, G);
    }
    if (params_.deskew_correction == DeskewCorrection::state) {
      turned = (F.block<3, 3>(block::theta, block::theta) * turned).eval();
      turned.middleCols<kStateDim - block::b_w>(block::b_w) +=
          F.block<3, kStateDim - block::b_w>(block::theta, block::b_w);
    }
    const ImuNoise noise =
        params_.noise.over(from, to, sensor_, state_.b_w, {unobservable_, window.imu_gap, unresolved_.density()});
    motion_->propagate_covariance(state, from, to, noise, P_);
    if (sensors_.active()) sensors_.propagate(F, from, to, P_);
    walk_gravity(params_.estimated, state.g, to_seconds(to.t - from.t), P_);
    const MotionSegment segment = motion_->step(state, from, to);
    path_.append(segment, state);
  }
  state.t = window.plan.end;
  // eq. DSK-3: pose at the end; mean error of the rate over the window; velocity at the end.
  seen_.setZero();
  seen_.topLeftCorner<6, 6>().setIdentity();
  seen_.middleRows<3>(6) = turned / std::max(to_seconds(state.t - path_.begin().t), 1e-6);
  seen_.block<3, 3>(9, block::v).setIdentity();
  path_.close(state);
  if (hold_calibration(imu, P_)) sensors_.forget_state();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  state_ = state;
}

void Ieskf::reserve(std::size_t fresh, std::size_t history) {
  fresh_.reserve(fresh, *residual_);
  // From the first window on, although a history comes later: usually not more than two points per fresh one.
  history_.reserve(std::max(history, fresh), *residual_);
  if (records_.capacity() < fresh) records_.reserve(2 * fresh);
}

void Ieskf::associate(WindowMatches& set, const NavState& at, const Map& map, std::uint32_t max_stamp) {
  const double windows = windows_per(params_.shared_time, plan_);
  set.associate(map, *residual_, frame_.viewpoint(at.pose()), max_stamp, feature_class::none, windows);
  if (!params_.gate_again) set.left_out.assign(set.body.size(), 0);
}

/// The normal equations of what the points see (eq. DSK-3).
void Ieskf::project_to_seen(const WindowInformation& sum, SeenMatrix& A, SeenVector& b) const {
  A.setZero();
  b.setZero();
  A.topLeftCorner<6, 6>() = sum.A;
  b.head<6>() = sum.b;
  if (params_.deskew_correction == DeskewCorrection::state) {
    A.topRightCorner<6, 6>() = -sum.A1;
    A.bottomLeftCorner<6, 6>() = -sum.A1.transpose();
    A.bottomRightCorner<6, 6>() = sum.A2;
    b.tail<6>() = -sum.b1;
  }
}

void Ieskf::load_fresh() {
  fresh_.load(frame_);
  const WindowTrajectory& trajectory = path_.trajectory();
  const TimeNs end = trajectory.predicted_end().t;
  for (const TimeNs t : frame_.match_time()) {
    if (params_.deskew_correction == DeskewCorrection::state) fresh_.lag.push_back(to_seconds(end - t));
    if (params_.deskew_correction == DeskewCorrection::linear) fresh_.share.push_back(trajectory.share(t));
  }
}

/// Whether the step from an iterate with these residuals reaches the points in proportion to their time. eq. DSK-4.
bool Ieskf::spreads(const WindowInformation& fresh) {
  const double rms = std::sqrt(fresh.squared_sum / static_cast<double>(std::max<std::size_t>(fresh.accepted, 1)));
  const double before = std::exchange(rms_, rms);
  switch (params_.redeskew) {
    case Redeskew::every_iteration:
      break;
    case Redeskew::once_registered:
      spreading_ = spreading_ || rms <= params_.redeskew_below * sigma_ / params_.sigma;
      break;
    case Redeskew::until_converged:
      spreading_ = spreading_ && rms <= (1.0 - params_.redeskew_fall) * before;
      break;
  }
  return spreading_;
}

/// Brings the fresh points to the end of the window again, as the step from the pose `before` to the iterate `at` says.
void Ieskf::redeskew(const Pose& before, const NavState& at, const WindowInformation& fresh) {
  const CpuTimer timer(result_.times.deskew, result_.times.solve);
  if (spreads(fresh)) {
    spread_end_ = spread_end_ * (before.inverse() * at.pose());
    if (params_.deskew_correction != DeskewCorrection::rigid) ++redeskews_;
  } else if (!sensors_.active()) {
    return;
  }
  if (sensors_.active()) frame_.set_extrinsic(sensors_.T_imu_lidar());
  if (params_.deskew_correction == DeskewCorrection::state) {
    path_.repropagate(*motion_, at);
    frame_.deskew_matches(path_.trajectory());
    fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
    return;
  }
  WindowTrajectory& trajectory = path_.trajectory();
  trajectory.correct(params_.redeskew == Redeskew::every_iteration ? at.pose() : spread_end_);
  if (sensors_.active()) {
    frame_.deskew_matches(path_.trajectory());
    fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
  }
  if (trajectory.spread() == WindowTrajectory::Spread::rigid) return;
  trajectory.to_end(
      fresh_.body.size(), [&](std::size_t i) -> const Vec3& { return frame_.match_body()[i]; },
      [&](std::size_t i) { return frame_.match_time()[i]; }, [&](std::size_t i, const Vec3& p) { fresh_.body[i] = p; });
}

/// All residuals at the iterate.
Ieskf::Evaluation Ieskf::linearize(const NavState& at, const StepContext& context) {
  Evaluation sums;
  sums.fresh = fresh_.sum_up(*residual_, sigma_, at, std::numeric_limits<double>::infinity(), exec_);
  const double gate = context.histories.gate(sigma_);
  sums.history = history_.sum_up(*residual_, sigma_, at, gate, exec_);
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  constexpr double none = std::numeric_limits<double>::infinity();
  result_.fresh_matches = static_cast<std::uint32_t>(fresh_.matches(rows, sums.fresh.accepted, none));
  result_.history_matches = static_cast<std::uint32_t>(history_.matches(rows, sums.history.accepted, gate));
  if (directions_.active()) find_weak_directions(at, sums.fresh);
  return sums;
}

/// eq. IESKF-12.
void Ieskf::find_weak_directions(const NavState& at, const WindowInformation& fresh) {
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  const bool fitted = rows == 1 && !residual_->surfaces_from_map();
  directions_.find({fresh_, rows, fitted ? sigma_ : 0.0, at.R}, fresh.A);
}

/// eq. IESKF-10, while the iterate is the prior. The history is no innovation: its points have been matched before.
double Ieskf::innovation_per_row(const WindowInformation& fresh) const {
  SeenMatrix A;
  SeenVector b;
  project_to_seen(fresh, A, b);
  const double nis = sensors_.active() ? sensors_.squared_innovation(P_, seen_, state_.R, A, b, fresh.weighted_sum)
                                       : squared_innovation<kSeenDim>(P_, seen_, A, b, fresh.weighted_sum);
  return nis / static_cast<double>(fresh.accepted);
}

/// From the iterate `at`, which is `d` from the prior; `P` is the prior's covariance seen from there.
StateVector Ieskf::step(const NavState& at, const StateVector& d, const StateMatrix& P, const NormalEquations& normal) {
  if (sensors_.active()) return sensors_.step(P_, seen_, at, d, normal.A_all, normal.b_all);
  return iteration_step<kSeenDim>(P, seen_, normal.A_all, normal.b_all, d);
}

/// The normal equations of fresh points, and of all with the history's weight.
Ieskf::NormalEquations Ieskf::assemble(const Evaluation& sums, double history_weight) const {
  NormalEquations normal;
  project_to_seen(sums.fresh, normal.A_new, normal.b_all);
  normal.A_all = normal.A_new;
  normal.A_all.topLeftCorner<6, 6>() += history_weight * sums.history.A;
  normal.b_all.head<6>() += history_weight * sums.history.b;
  if (directions_.damps()) {  // eq. IESKF-13
    const SeenMatrix fresh = directions_.damping(normal.A_new) * normal.A_new;
    const SeenMatrix L = directions_.damping(normal.A_all), all = L * normal.A_all;
    normal.A_new = 0.5 * (fresh + fresh.transpose());
    normal.A_all = 0.5 * (all + all.transpose());
    normal.b_all = (L * normal.b_all).eval();
  }
  return normal;
}

/// eq. IESKF-11.
bool Ieskf::has_converged(const StateVector& delta) const {
  const double turn = params_.converged_deg * kRadPerDeg, shift = params_.converged_m;
  if (params_.converged == Converged::pose) {
    return delta.segment<3>(block::theta).norm() / kRadPerDeg < params_.converged_deg &&
           delta.segment<3>(block::p).norm() < shift;
  }
  const auto largest = [&](int at) { return delta.segment<3>(at).cwiseAbs().maxCoeff(); };
  const Vec3& g = state_.g;
  const Vec3 tilt = g.cross(delta.segment<3>(block::g)) / g.squaredNorm();
  return largest(block::theta) < turn && tilt.norm() < turn && largest(block::p) < shift && largest(block::v) < shift &&
         largest(block::b_w) < shift && largest(block::b_a) < shift;
}

/// Whether neighbours are searched again after iteration `iteration` (0: the first). eq. IESKF-11.
bool Ieskf::searches_next(int iteration, bool converged, int converged_steps) const {
  switch (params_.association) {
    case Association::every_iteration:
      return true;
    case Association::once:
      return false;
    case Association::on_convergence:
      return converged || (params_.search_last && converged_steps == 0 && iteration + 2 == params_.max_iterations);
  }
  return false;
}

void Ieskf::iterate(const HistorySelection& past, const StepContext& context) {
  const NavState prior = state_;
  NavState x = prior;
  bool search = true;
  sensors_.begin();
  spread_end_ = path_.trajectory().predicted_end().pose();
  spreading_ = params_.redeskew != Redeskew::once_registered;
  rms_ = std::numeric_limits<double>::infinity();
  int converged_steps = 0;
  for (int j = 0; j < params_.max_iterations; ++j) {
    {
      const CpuTimer timer(search ? result_.times.associate : result_.times.solve);
      fresh_.place(x.pose());
      history_.place(x.pose());
      if (search) {
        associate(fresh_, x, context.map, 0xffffffff);
        associate(history_, x, context.map, past.max_stamp);
      }
    }
    const CpuTimer timer(result_.times.solve);
    const Evaluation sums = linearize(x, context);
    result_.iterations = j + 1;
    if (static_cast<std::int64_t>(result_.fresh_matches) < params_.min_matches)
      return refuse(UpdateStatus::few_matches);
    const NormalEquations normal = assemble(sums, context.histories.weight(sums.fresh.accepted, sums.history.accepted));
    const StateVector d = box_minus(x, prior);
    const StateMatrix P = transported_covariance(P_, d.head<3>());
    if (j == 0) result_.nis = innovation_per_row(sums.fresh);
    const StateVector delta = step(x, d, P, normal);
    if (!delta.allFinite()) return refuse(UpdateStatus::non_finite);
    const Pose before = x.pose();
    x = box_plus(x, delta, params_.estimated.gravity != Gravity::free);
    redeskew(before, x, sums.fresh);
    const double turn = delta.segment<3>(block::theta).norm() / kRadPerDeg;
    const double shift = delta.segment<3>(block::p).norm();
    const bool converged = has_converged(delta);
    converged_steps += converged ? 1 : 0;
    // FAST-LIO2's rule searches again once the step has converged, and needs a second converged step to end.
    const int enough = params_.association == Association::on_convergence ? 2 : 1;
    if (converged_steps >= enough || j + 1 == params_.max_iterations) {
      result_.status = status_of_last_step(settled(turn, params_.converged_deg) && settled(shift, params_.converged_m));
      return accept(x, P, normal, past);
    }
    search = searches_next(j, converged, converged_steps);
  }
}

void Ieskf::accept(const NavState& posterior, const StateMatrix& P_iterate, const NormalEquations& normal,
                   const HistorySelection& past) {
  const StateMatrix P =
      sensors_.active() ? sensors_.posterior(normal.A_new, normal.A_all, past.covariance)
                        : posterior_covariance<kSeenDim>(P_iterate, seen_, normal.A_new, normal.A_all, past.covariance);
  if (!P.allFinite() || P.diagonal().minCoeff() < 0.0) return refuse(UpdateStatus::non_finite);

  judge_view(result_, normal.A_new.topLeftCorner<6, 6>(), params_.degenerate_sigma, plan_);
  unobservable_ = result_.unobservable;
  const Vec3 g = std::exchange(state_, posterior).g;
  P_ = P;
  if (params_.estimated.gravity != Gravity::free) {
    turn_with_gravity(g, state_.g, block::g, P_);
    sensors_.turn_with_gravity(g, state_.g);
  }
  result_.accepted = true;
  result_.insert = true;
  if (velocity_.active()) find_velocity_alone();
  dead_reckoning_.begin(state_.t, P_);
}

/// eq. INI-3: the first windows were de-skewed with a wrong velocity; their displacements must not pass for
/// acceleration.
void Ieskf::find_velocity_alone() {
  velocity_.step(plan_, state_);
  P_ = start_covariance(velocity_.sigma_velocity());
  result_.restart_map = true;
}

void Ieskf::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  sensors_.restore();
  unobservable_ = dead_reckoning_.begun();
  // Unseen space can only become known by inserting it: go on while dead reckoning is still good (eq. IESKF-8).
  result_.insert = status == UpdateStatus::few_matches && dead_reckoning_.good(state_.t, P_);
}

const Update& Ieskf::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  redeskews_ = 0;
  plan_ = window.plan;
  const StateMatrix P_before = P_;
  const NavState before = state_;
  sensors_.begin();
  propagate(window);
  const bool finite =
      P_.allFinite() && state_.p.allFinite() && state_.v.allFinite() && state_.R.allFinite() && state_.g.allFinite();
  if (!finite) {  // back to the last finite state; the points stay as measured, and nothing is done with them
    P_ = P_before;
    state_ = before;
    state_.t = window.plan.end;
    path_.start(state_, {});
    path_.close(state_);
    refuse(UpdateStatus::non_finite);
  }
  result_.prior = state_;
  frame_.load(window.fresh, path_.trajectory(), context.samplers, result_.times);
  reserve(frame_.match_body().size(), past.points.size());
  load_fresh();
  history_.load(past, state_.pose());  // eq. HIS-1: seen from the prior, then held fixed
  result_.history_points = static_cast<std::uint32_t>(past.points.size());
  if (finite && context.map.size() == 0) {
    result_.status = UpdateStatus::initialising;
    dead_reckoning_.begin(state_.t, P_);
  } else if (finite) {
    iterate(past, context);
  }
  finish(finite);
  return result_;
}

/// Residuals of the fresh points at the posterior: the normal equations are not needed any more.
void Ieskf::record_residuals() {
  fresh_.place(state_.pose());
  fresh_.evaluate(*residual_, sigma_);
  const auto rows_per_match = static_cast<std::size_t>(residual_->rows_per_match());
  fresh_.record(rows_per_match, records_, result_.residual_rms);
}

/// The trajectory ends in the state; what the points have seen of the correction in proportion to their time stays. eq.
/// DSK-4.
void Ieskf::correct_trajectory() {
  WindowTrajectory& trajectory = path_.trajectory();
  if (params_.redeskew == Redeskew::every_iteration || !result_.accepted) return trajectory.correct(state_.pose());
  trajectory.correct(spread_end_);
  trajectory.move(state_.pose() * spread_end_.inverse());
}

void Ieskf::finish(bool predicted) {
  if (params_.deskew_correction == DeskewCorrection::state) {
    const CpuTimer timer(result_.times.deskew);
    if (!result_.accepted && predicted) path_.repropagate(*motion_, state_);  // an iteration may have left another one
    frame_.deskew(path_.trajectory());
  }
  if (sensors_.active()) {
    const CpuTimer timer(result_.times.deskew);
    frame_.set_extrinsic(sensors_.T_imu_lidar());
    if (predicted) frame_.deskew(path_.trajectory());
    result_.sensor = sensors_.estimate();
  }
  const CpuTimer timer(result_.times.solve);
  correct_trajectory();
  frame_.place(path_.trajectory());
  if (result_.accepted) {
    record_residuals();
    if (!residual_->surfaces_from_map()) result_.neighbours = &fresh_.neighbours;
  } else {
    records_.assign(fresh_.body.size(), MatchRecord{});
  }
  if (result_.accepted && params_.deskew_correction != DeskewCorrection::state) {
    path_.trajectory().correct_states(path_.states(), state_);
  }
  path_.states().back() = state_;
  result_.P = P_;
  hand_over(result_, frame_, records_, state_, path_.states(), path_.trajectory());
}

}  // namespace aslio::plugins
