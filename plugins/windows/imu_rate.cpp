#include "windows/imu_rate.hpp"

#include <algorithm>
#include <numbers>

#include "aslio/core/lie.hpp"
#include "aslio/toolkit/tiling.hpp"

namespace aslio::plugins {

void ImuRateWindow::describe(config::Binder& b, Params& p) {
  b.real("frame_length", p.frame_length, "s", {.min = 1e-3, .max = 10.0},
         "length of a frame, and of a window with its history");
  b.real("rate_unit_deg", p.rate_unit_deg, "deg/s", {.above = 0.0, .max = 1e5},
         "angular rate that counts as one unit of intensity (1.5 rad/s)");
  b.real("acc_unit", p.acc_unit, "m/s^2", {.above = 0.0, .max = 1e4},
         "acceleration, gravity removed, that counts as one unit of intensity");
  b.integer("n_max", p.n_max, "", {.min = 1, .max = static_cast<double>(WindowPlan::kMaxCuts)},
            "most sub-frames of a frame");
  b.choice("emit", p.emit, {{"updates", Emit::updates}, {"cuts", Emit::cuts}},
           "an update per sub-frame, or one per frame with the ends of its sub-frames (only for an estimator that "
           "smooths over them)");
}

ImuRateWindow::ImuRateWindow(const Params& params, const BuildContext&)
    : frame_length_(to_ns(params.frame_length)),
      rate_unit_(params.rate_unit_deg * std::numbers::pi / 180.0),
      acc_unit_(params.acc_unit),
      n_max_(params.n_max),
      emit_(params.emit) {}

/// eq. WIN-6. Gravity is taken off at the attitude the gyro gives from the last posterior on: in a fast turn the mean
/// force of the frame would not do. A sample that is not finite counts for nothing, and the next one turns the attitude
/// on over its time, too.
double ImuRateWindow::intensity(const StreamView& stream, TimeNs begin, const NavState& from) const {
  double largest = 0;
  Mat3 R = from.R;
  for (const ImuSample& sample : stream.imu(begin, begin + frame_length_)) {
    if (!sample.gyro.allFinite() || !sample.acc.allFinite()) continue;
    const Vec3 rate = sample.gyro - from.b_w;
    R = R * exp_so3(rate * to_seconds(sample.t - begin));
    begin = sample.t;
    const double acceleration = (R * (sample.acc - from.b_a) + from.g).norm();
    largest = std::max({largest, rate.norm() / rate_unit_, acceleration / acc_unit_});
  }
  return largest;
}

void ImuRateWindow::cut(WindowPlan& plan) const {
  for (std::int64_t i = 1; i <= parts_ && plan.cut_count < WindowPlan::kMaxCuts; ++i) {
    const TimeNs at = i == parts_ ? plan.end : std::min(part_end(i), plan.end);
    if (at <= plan.fresh_begin || (plan.cut_count > 0 && at <= plan.cuts[plan.cut_count - 1])) continue;
    plan.cuts[plan.cut_count++] = at;
  }
}

std::optional<WindowPlan> ImuRateWindow::next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) {
  if (exhausted(stream, feedback.t)) return std::nullopt;
  const bool goes_on = part_ < parts_ && feedback.t == expected_;
  if (!goes_on) {
    if (stream.imu_until() < feedback.t + frame_length_) return std::nullopt;
    frame_begin_ = feedback.t;
    const double units = intensity(stream, feedback.t, feedback.state);
    parts_ = std::min(1 + static_cast<std::int64_t>(std::min(units, 1e6)), n_max_);
    part_ = 0;
    expected_ = feedback.t;
  }
  const TimeNs shift = (emit_ == Emit::cuts ? part_end(parts_) : part_end(part_ + 1)) - feedback.t;
  const auto tile = settle(stream, {.begin = feedback.t, .shift = shift, .limit = shift});
  if (!tile) return std::nullopt;
  part_ = emit_ == Emit::cuts ? parts_ : part_ + 1;
  expected_ = feedback.t + shift;

  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  plan.history_begin = std::min(tile->end - frame_length_, feedback.t);
  plan.seg_time = static_cast<double>(parts_);
  plan.shift_time = to_seconds(frame_length_) / static_cast<double>(parts_);
  plan.partial = tile->partial;
  if (emit_ == Emit::cuts && parts_ > 1 && plan.end <= part_end(parts_)) cut(plan);  // not across a gap
  return plan;
}

}  // namespace aslio::plugins
