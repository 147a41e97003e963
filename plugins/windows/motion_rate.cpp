#include "windows/motion_rate.hpp"

#include <algorithm>
#include <numbers>

namespace aslio::plugins {

void MotionRateWindow::describe(config::Binder& b, Params& p) {
  b.real("frame_length", p.frame_length, "s", {.min = 1e-3, .max = 10.0}, "length of a window with its history");
  b.optional_real("slow_period", p.slow_period, "s", {.min = 1e-3, .max = 10.0}, "frame_length",
                  "time between updates while the sensor hardly turns");
  b.real("fast_period", p.fast_period, "s", {.min = 1e-3, .max = 10.0}, "time between updates in turns");
  b.real("threshold_deg", p.threshold_deg, "deg/s", {.above = 0.0, .max = 1e5},
         "a gyro sample that turns faster, its bias removed, is a turn");
  b.real("hold", p.hold, "s", {.min = 0.0, .max = 10.0}, "time after a turn for which updates stay fast");
  b.integer("min_points", p.min_points, "points", {.min = 0, .max = 1e6},
            "with fewer raw points in the sensor's range the time between updates grows, up to frame_length");
  b.require(!p.slow_period || *p.slow_period <= p.frame_length, "slow_period", "must not exceed frame_length");
  b.require(p.fast_period <= p.slow_period.value_or(p.frame_length), "fast_period",
            p.slow_period ? "must not exceed slow_period" : "must not exceed frame_length");
}

MotionRateWindow::MotionRateWindow(const Params& params, const BuildContext& context)
    : frame_length_(to_ns(params.frame_length)),
      slow_period_(to_ns(params.slow_period.value_or(params.frame_length))),
      fast_period_(to_ns(params.fast_period)),
      hold_(to_ns(params.hold)),
      request_{.limit = frame_length_,
               .min_points = static_cast<std::size_t>(params.min_points),
               .min_range = context.sensor.min_range,
               .max_range = context.sensor.max_range} {
  const double threshold = params.threshold_deg * std::numbers::pi / 180.0;
  squared_threshold_ = threshold * threshold;
}

TimeNs MotionRateWindow::reach() const { return std::max(frame_length_, hold_); }

std::optional<TimeNs> MotionRateWindow::turn_in(const StreamView& stream, TimeNs begin, TimeNs end,
                                                const Vec3& gyro_bias) const {
  for (const ImuSample& sample : stream.imu(begin, end)) {
    if ((sample.gyro - gyro_bias).squaredNorm() > squared_threshold_) return sample.t;
  }
  return std::nullopt;
}

/// eq. WIN-5. The IMU is ahead of the points, so the trigger may look at the pending window itself: a control that had
/// to wait for the next window would lose for that reason alone.
std::optional<TimeNs> MotionRateWindow::wanted_shift(const StreamView& stream, const Feedback& feedback) const {
  const TimeNs begin = feedback.t, end = begin + slow_period_;
  if (turn_in(stream, begin - hold_, begin, feedback.state.b_w)) return fast_period_;
  const auto turn = turn_in(stream, begin, std::min(end, stream.imu_until()), feedback.state.b_w);
  if (turn) return std::max(*turn - begin, fast_period_);
  if (stream.imu_until() < end) return std::nullopt;
  return slow_period_;
}

std::optional<WindowPlan> MotionRateWindow::next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) {
  if (exhausted(stream, feedback.t)) return std::nullopt;
  const auto shift = wanted_shift(stream, feedback);
  if (!shift) return std::nullopt;
  request_.begin = feedback.t;
  request_.shift = *shift;
  const auto tile = settle(stream, request_);
  if (!tile) return std::nullopt;
  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  plan.history_begin = std::min(tile->end - frame_length_, feedback.t);
  plan.shift_time = to_seconds(*shift);
  plan.extended = tile->extended;
  plan.partial = tile->partial;
  return plan;
}

}  // namespace aslio::plugins
