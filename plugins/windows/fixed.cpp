#include "windows/fixed.hpp"

#include <algorithm>

#include "aslio/toolkit/tiling.hpp"

namespace aslio::plugins {

namespace {

/// Fresh interval that ends with a sweep, so that windows and revolutions of a spinning sensor coincide.
std::optional<Tile> settle_sweep(const StreamView& stream, TimeNs begin, TimeNs period) {
  if (exhausted(stream, begin)) return std::nullopt;
  const auto end = stream.sweep_end_after(begin);
  if (!end || !arrived(stream, *end)) return std::nullopt;
  return Tile{.end = *end, .extended = false, .partial = *end - begin > 2 * period};
}

}  // namespace

void FixedWindow::describe(config::Binder& b, Params& p) {
  b.real("period", p.period, "s", {.min = 1e-3, .max = 10.0},
         "time between updates; with 'cut: sweep' that of the sensor's sweeps");
  b.choice("cut", p.cut, {{"time", Cut::time}, {"sweep", Cut::sweep}},
           "where a window ends: every period, or with the last point of each sweep");
  b.optional_real("frame_length", p.frame_length, "s", {.min = 1e-3, .max = 10.0}, "= period",
                  "length of a window with its history; what exceeds the period is history");
  b.real("warmup", p.warmup, "s", {.min = 0.0, .max = 1000.0},
         "time after the first insertion into the map with an update every frame_length, as in sod_adaptive, which "
         "starts in motion at its slowest rate");
  b.require(p.warmup == 0.0 || (p.frame_length && p.cut == Cut::time), "warmup",
            "is a time of updates every frame_length: it needs that to be set, and 'cut: time'");
  b.require(!p.frame_length || p.cut == Cut::sweep || *p.frame_length >= p.period, "frame_length",
            "must be at least the period, or points between two windows would never be used");
}

FixedWindow::FixedWindow(const Params& params, const BuildContext& context)
    : period_(to_ns(params.cut == Cut::sweep ? context.sensor.sweep_period : params.period)),
      frame_length_(params.frame_length ? to_ns(*params.frame_length) : period_),
      warmup_(to_ns(params.warmup)),
      cut_(params.cut) {}

std::optional<WindowPlan> FixedWindow::next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) {
  const bool warming_up =
      warmup_ > 0 && (feedback.first_insertion == kTimeMax || feedback.t - feedback.first_insertion < warmup_);
  const TimeNs period = warming_up ? frame_length_ : period_;
  const auto tile = cut_ == Cut::sweep ? settle_sweep(stream, feedback.t, period_)
                                       : settle(stream, {.begin = feedback.t, .shift = period, .limit = period});
  if (!tile) return std::nullopt;
  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  // Without a longer frame there is no history, not even in a window that came out shorter than the period.
  plan.history_begin = frame_length_ > period_ ? std::min(tile->end - frame_length_, feedback.t) : feedback.t;
  plan.partial = tile->partial;
  return plan;
}

TimeNs FixedWindow::reach() const { return frame_length_ > period_ ? frame_length_ : 0; }

}  // namespace aslio::plugins
