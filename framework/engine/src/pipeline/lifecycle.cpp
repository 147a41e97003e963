#include "lifecycle.hpp"

#include <algorithm>
#include <utility>

namespace aslio::pipeline {

Lifecycle::Lifecycle(const PipelineConfig& config, const SensorModel& sensor, TimeNs start_offset,
                     stream::MeasurementStream& stream)
    : config_(config),
      sensor_(sensor),
      start_offset_(start_offset),
      stream_(stream),
      tracking_(config.limits, sensor.sweep_period) {}

std::optional<InitialState> Lifecycle::find_start(const Estimator& estimator, bool misled) {
  const auto initial = started() ? next_start(estimator, misled) : first_start(estimator.uses_imu());
  if (initial) begin(initial->state);
  return initial;
}

std::optional<InitialState> Lifecycle::first_start(bool inertial) {
  if (!stream_.settled()) {
    forget_waiting_data();
    return std::nullopt;
  }
  auto found = inertial ? initialise(stream_, config_.initialisation, sensor_, start_offset_)
                        : initialise_without_imu(stream_, start_offset_);
  if (!found || !look_at_sweeps(*found, inertial, nullptr)) {
    forget_waiting_data();
    return std::nullopt;
  }
  scale_specific_force(*found);
  initialisation_ = std::move(found);
  tracking_.begin(initialisation_->initial.state.t);
  // A silence is known to be longer than max_gap once points that much later came, and the IMU may still be late.
  stream_.wait_for_imu(to_ns(config_.limits.max_gap) + kMaxKept);
  return initialisation_->initial;
}

std::optional<InitialState> Lifecycle::next_start(const Estimator& estimator, bool misled) {
  const bool inertial = estimator.uses_imu();
  if (!new_start_) new_start_.emplace(last_known(estimator.state(), misled), config_.initialisation, sensor_);
  if (inertial && stream_.last_point() > kTimeMin + points_kept()) {
    // IMU data of points that are kept no longer.
    new_start_->skip(stream_.last_point() - points_kept() - to_ns(config_.initialisation.time));
  }
  if (!found_start_) found_start_ = new_start_->find(stream_, estimator);
  if (!found_start_) {
    if (inertial) stream_.release(new_start_->keep_imu_from());
    stream_.forget_points(new_start_->searched_until());
    forget_waiting_data();
    return std::nullopt;
  }
  const Mat3 heading = found_start_->initial.state.R;
  if (!look_at_sweeps(*found_start_, inertial, &heading)) return std::nullopt;
  const auto found = std::exchange(found_start_, std::nullopt);
  new_start_.reset();
  ++segment_;
  tracking_.restart(found->initial.state.t);
  return found->initial;
}

void Lifecycle::begin(const NavState& state) {
  last_point_ = last_accepted_ = segment_begin_ = state.t;
  believed_ = state.pose();
  stream_.release(state.t);
}

/// eq. INI-7. Of the start of the run alone: the sensor stays the same, and after a loss the mean is often of a motion.
void Lifecycle::scale_specific_force(const Initialisation& found) {
  if (!config_.initialisation.scale_specific_force || found.mean_force <= 0) return;
  stream_.scale_specific_force(kStandardGravity / found.mean_force);
}

/// Lets the first sweeps confirm or correct a start (eq. INI-6). False while they have not arrived.
bool Lifecycle::look_at_sweeps(Initialisation& found, bool inertial, const Mat3* heading) {
  if (!config_.initialisation.register_sweeps) return true;
  const bool declared_rest = config_.initialisation.mode == InitialisationMode::static_start;
  const TimeNs begin = found.initial.state.t, end = begin + sweep_motion_span(sensor_);
  // An IMU that falls silent is waited for as long as the points of the sweeps are kept.
  const TimeNs patience = points_kept() - sweep_motion_span(sensor_);
  const bool arrived = stream_.points_until() >= end && (!inertial || stream_.imu_until() >= end);
  if (!arrived && !stream_.finished() && stream_.last_point() < end + patience) return false;
  std::vector<ImuSample> imu;
  if (inertial) stream_.imu_covering(begin, end, imu);
  const auto motion = find_sweep_motion(stream_.points(begin, end), imu, begin, sensor_);
  if (motion && declared_rest && segment_ == 0) doubt_declared_rest(found, *motion);
  if (motion && !declared_rest) apply_sweep_motion(found, *motion, heading);
  return true;
}

/// Without IMU data nothing begins, nor without points, and what comes of the others would pile up.
void Lifecycle::forget_waiting_data() {
  if (stream_.last_point() > kTimeMin + points_kept()) stream_.forget_points(stream_.last_point() - points_kept());
  const TimeNs imu_kept = kMaxKept + to_ns(config_.initialisation.time);
  const bool no_points_yet = !stream_.first_point() && stream_.last_imu() > kTimeMin + imu_kept;
  if (no_points_yet && stream_.imu_settled()) stream_.release(stream_.last_imu() - imu_kept);
}

void Lifecycle::forget_unused_imu() {
  constexpr TimeNs kept = 600 * kSecond;
  if (!stream_.imu_settled() || stream_.last_imu() < kTimeMin + kept) return;
  if (stream_.last_imu() - kept > stream_.last_point()) stream_.release(stream_.last_imu() - kept);
}

/// Of points that wait for IMU data: those of the first sweeps (INI-6) are among them, also of a slow sensor.
TimeNs Lifecycle::points_kept() const { return kMaxKept + sweep_motion_span(sensor_) - kSweepsOfMotion * kSecond / 10; }

LastKnown Lifecycle::last_known(const NavState& state, bool misled) const {
  LastKnown known{tracking_.losses().back().t + start_offset_, believed_, {}, last_accepted_, config_.limits.max_speed};
  // Soon after a start in motion an estimator does not know yet how fast it is.
  const bool learnt = last_accepted_ - segment_begin_ >= kSecond && !misled;
  if (learnt && sound(state)) known.state = state;
  return known;
}

void Lifecycle::note_clock_jumps() {
  for (; clock_jumps_ < stream_.clock_jumps().size(); ++clock_jumps_) {
    const stream::ClockJump& jump = stream_.clock_jumps()[clock_jumps_];
    if (!started()) continue;
    new_start_.reset();
    found_start_.reset();
    tracking_.observe_clock_jump(jump.t, jump.by);
  }
}

void Lifecycle::note_gaps(const WindowPlan& plan, bool inertial) {
  note_gap(plan);
  if (lost() || !inertial) return;
  const auto silent_after = stream_.imu_silent_after(plan.fresh_begin, plan.end, to_ns(config_.limits.max_gap));
  if (silent_after) tracking_.observe_silent_imu(*silent_after);
}

void Lifecycle::note_gap(const WindowPlan& plan) {
  const auto points = stream_.points(plan.fresh_begin, plan.end);
  if (points.empty()) return;
  tracking_.observe_gap(last_point_, points.front().t - 1);
  if (plan.end - plan.fresh_begin > to_ns(config_.limits.max_gap)) {  // only then may one lie between its points
    for (std::size_t i = 1; i < points.size() && !lost(); ++i) {
      tracking_.observe_gap(points[i - 1].t, points[i].t - 1);
    }
  }
  last_point_ = points.back().t;
}

bool Lifecycle::note_update(const Window& window, const Update& update, bool unread,
                            const std::optional<std::string>& alarm) {
  const TimeNs end = window.plan.end;
  // A gap at the begin of the window is no time in which the estimator failed: its silence begins with the data.
  const TimeNs data_begin = window.fresh.empty() ? window.plan.fresh_begin : window.fresh.front().t;
  const bool without_view = lacks_view(window, update);
  tracking_.observe(update, data_begin, end, without_view, unread);
  if (alarm) tracking_.observe_alarm(end, *alarm);
  // One that is lost by silence has a dead-reckoned pose; one that is lost by its state, the last that was accepted.
  // One that is lost by an alarm has its pose from points that do not fit.
  if (!alarm && (lost() ? sound(update.state) : update.accepted)) believed_ = update.state.pose();
  if (update.accepted && !lost()) last_accepted_ = end;
  return without_view;
}

bool Lifecycle::lacks_view(const Window& window, const Update& update) {
  constexpr double kHardlyAny = 0.1, kShare = 0.05;
  const double length = to_seconds(window.plan.end - window.plan.fresh_begin);
  const double density = static_cast<double>(window.fresh.size()) / std::max(length, 1e-3);
  if (update.accepted) usual_density_ += (usual_density_ > 0 ? kShare : 1.0) * (density - usual_density_);
  return update.status == UpdateStatus::few_matches && density < kHardlyAny * usual_density_;
}

bool Lifecycle::sound(const NavState& state) const {
  return state.R.allFinite() && state.p.allFinite() && state.v.allFinite() &&
         state.v.norm() <= config_.limits.max_speed;
}

}  // namespace aslio::pipeline
