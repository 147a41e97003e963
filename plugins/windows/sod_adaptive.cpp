#include "windows/sod_adaptive.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::plugins {

namespace {

/// Step at which coming points are looked at [ns]: 2.6 deg of a 257 deg/s turn.
constexpr TimeNs kLookaheadStep = 10'000'000;
/// IMU data of so long [ns] tell its rate.
constexpr double kImuMemory = 2e9;
/// An IMU that says nothing for so long [ns], and for so many of its steps, is in a gap.
constexpr double kUnread = 5e7, kUnreadSteps = 2.5;
/// And for so long after it [ns] only whole views correct what it left wrong.
constexpr TimeNs kRecovery = kSecond / 2;

/// Silence before the first of `data`, of which `last` came before; `last` becomes the last of them.
template <class T>
TimeNs silence(std::span<const T> data, TimeNs& last) {
  if (data.empty()) return 0;
  const TimeNs before = last == kTimeMin ? 0 : data.front().t - last;
  last = data.back().t;
  return before;
}

}  // namespace

void SodAdaptiveWindow::describe(config::Binder& b, Params& p) {
  b.real("frame_length", p.frame_length, "s", {.min = 1e-3, .max = 10.0},
         "length L of a window with its history; the longest time between updates");
  b.real("seg_step", p.seg_step, "", {.min = 1e-3, .max = 1.0},
         "loss of overlap per segment: n = ceil((1 - overlap) / seg_step) + 1, an update every 2 L / n");
  b.removed("n_least", "use n_min");
  b.integer("n_min", p.n_min, "", {.min = 2, .max = 1000},
            "minimum number of segments n. With 2, as in the paper, a full overlap leaves no old point in the window. "
            "With more, (n - 2) / n of the window are always old points");
  b.integer("n_max", p.n_max, "", {.min = 2, .max = 1000}, "maximum number of segments n");
  b.real("shift_min", p.shift_min, "s", {.min = 1e-4, .max = 10.0},
         "shortest time between updates; acts as n <= 2 L / shift_min");
  b.real("warmup", p.warmup, "s", {.min = 0.0, .max = 1000.0},
         "time after the first insertion into the map during which the overlap is ignored (n = n_min)");
  b.flag("echo", p.echo,
         "n holds for n updates (2 L of data) before it may fall; without, it may fall at each update (an ablation)");
  b.choice("recover", p.recover, {{"step", Recover::step}, {"ramp", Recover::ramp}},
           "how n falls when an echo has ended: to the latest overlap at once, or by one per echo");
  b.flag("lookahead", p.lookahead,
         "score coming points at the predicted pose every 10 ms and cut the pending window short when n rises");
  b.integer("min_points", p.min_points, "points", {.min = 0, .max = 1e6},
            "with fewer raw points in the sensor's range the time between updates grows, up to L");
  b.integer("weak_segments", p.weak_segments, "", {.min = 2, .max = 1000},
            "minimum n after an update with few matches or a degenerate view, where even a full overlap says little. "
            "With n_min or less the overlap alone decides, as in the paper");
  b.integer("imu_samples", p.imu_samples, "", {.min = 0, .max = 1000},
            "minimum number of IMU samples per update, in the mean. It limits the rate (n_min or above), because "
            "motion between samples is interpolated, not measured; 0: no limit");
  b.require(p.n_min <= p.n_max, "n_min", "must not exceed n_max");
  b.require(p.n_min * to_ns(p.shift_min) <= 2 * to_ns(p.frame_length), "shift_min",
            "must not exceed 2 frame_length / n_min, the time between updates while the overlap is full");
}

SodAdaptiveWindow::SodAdaptiveWindow(const Params& params, const BuildContext& context)
    : frame_length_(to_ns(params.frame_length)),
      warmup_(to_ns(params.warmup)),
      lookahead_(params.lookahead),
      weak_segments_(params.weak_segments),
      imu_samples_(params.imu_samples),
      request_{.limit = frame_length_,
               .min_points = static_cast<std::size_t>(params.min_points),
               .min_range = context.sensor.min_range,
               .max_range = context.sensor.max_range},
      schedule_(params.seg_step, params.n_min, std::min(params.n_max, 2 * frame_length_ / to_ns(params.shift_min)),
                params.recover, params.echo) {
  request_.shift = schedule_.shift(frame_length_);
}

bool SodAdaptiveWindow::warming_up(const Feedback& feedback) const {
  return feedback.first_insertion == kTimeMax || feedback.t - feedback.first_insertion < warmup_;
}

void SodAdaptiveWindow::pace(std::span<const ImuSample> imu) {
  TimeNs before = last_imu_;
  for (const ImuSample& sample : imu) {
    if ((sample.faults & (imu_fault::gyro_dead | imu_fault::gyro_clipped)) == 0) last_read_ = sample.t;
    if (before != kTimeMin && sample.t - before <= kSecond) {  // more is a gap
      imu_time_ += static_cast<double>(sample.t - before);
      imu_intervals_ += 1;
    }
    if (imu_time_ > kImuMemory) {
      imu_time_ /= 2;
      imu_intervals_ /= 2;
    }
    before = sample.t;
  }
}

bool SodAdaptiveWindow::unread(TimeNs t) {
  if (last_read_ != kTimeMin &&
      static_cast<double>(t - last_read_) > std::max(kUnread, kUnreadSteps * imu_time_ / imu_intervals_)) {
    unread_until_ = t + kRecovery;
  }
  return t < unread_until_;
}

void SodAdaptiveWindow::absorb(const Feedback& feedback) {
  if (imu_samples_ > 0 && imu_time_ > 0) {  // eq. WIN-8
    // A hundredth of a segment more: stamps round.
    const double most = std::floor(2 * static_cast<double>(frame_length_) * imu_intervals_ /
                                       (static_cast<double>(imu_samples_) * imu_time_) +
                                   0.01);
    schedule_.limit(unread(feedback.t) ? 0 : static_cast<std::int64_t>(most));
  }
  // An almost empty map would score every frame as new. A frame with few matches is no reason to doubt a low overlap.
  if (warming_up(feedback)) {
    schedule_.restart();
  } else {
    const bool weak = feedback.status == UpdateStatus::few_matches || feedback.unobservable;
    schedule_.observe(feedback.overlap.value, weak ? weak_segments_ : 2);
  }
  request_.shift = schedule_.shift(frame_length_);
  probed_ = 0;
  awaits_feedback_ = false;
}

bool SodAdaptiveWindow::look_ahead(const StreamView& stream, TimeNs begin, OverlapProbe& probe) {
  while (probed_ + kLookaheadStep < request_.shift) {
    const TimeNs until = begin + probed_ + kLookaheadStep;
    if (!arrived(stream, until)) return false;
    probed_ += kLookaheadStep;
    // The points looked at belong to this window in any case.
    if (schedule_.anticipate(probe.overlap(until).value)) {
      request_.shift = std::max(schedule_.shift(frame_length_), probed_);
    }
  }
  return true;
}

bool SodAdaptiveWindow::follows_gap(const StreamView& stream, TimeNs begin, TimeNs end) {
  const TimeNs points = silence(stream.points(begin, end), last_point_);
  const TimeNs imu = silence(stream.imu(begin, end), last_imu_);
  return std::max({points, imu, end - begin}) > 2 * frame_length_;
}

std::optional<WindowPlan> SodAdaptiveWindow::next(const StreamView& stream, const Feedback& feedback,
                                                  OverlapProbe& probe) {
  if (awaits_feedback_) absorb(feedback);
  if (exhausted(stream, feedback.t)) return std::nullopt;
  if (lookahead_ && !warming_up(feedback) && !look_ahead(stream, feedback.t, probe)) return std::nullopt;
  request_.begin = feedback.t;
  const auto tile = settle(stream, request_);
  if (!tile) return std::nullopt;

  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  plan.history_begin = std::min(tile->end - frame_length_, feedback.t);
  plan.seg_time = static_cast<double>(schedule_.n());
  plan.shift_time = to_seconds(schedule_.shift(frame_length_));
  plan.echo = static_cast<std::uint32_t>(schedule_.echo());
  plan.extended = tile->extended;
  plan.partial = tile->partial;
  pace(stream.imu(feedback.t, tile->end));  // before last_imu_ moves on
  if (follows_gap(stream, feedback.t, tile->end)) schedule_.end_echo();
  awaits_feedback_ = true;
  return plan;
}

}  // namespace aslio::plugins
