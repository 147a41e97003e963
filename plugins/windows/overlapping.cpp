#include "windows/overlapping.hpp"

#include <algorithm>

#include "aslio/toolkit/tiling.hpp"

namespace aslio::plugins {

void OverlappingWindow::describe(config::Binder& b, Params& p) {
  b.real("length", p.length, "s", {.min = 1e-3, .max = 10.0}, "length of a window with its history");
  b.real("step", p.step, "s", {.min = 1e-3, .max = 10.0},
         "time between updates; SR-LIO cuts a sweep of 0.1 s in two, so an update comes every 0.05 s");
  b.require(p.step <= p.length, "step", "must not exceed length, or points between two windows would never be used");
}

OverlappingWindow::OverlappingWindow(const Params& params, const BuildContext&)
    : length_(to_ns(params.length)), step_(to_ns(params.step)) {}

std::optional<WindowPlan> OverlappingWindow::next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) {
  const auto tile = settle(stream, {.begin = feedback.t, .shift = step_, .limit = step_});
  if (!tile) return std::nullopt;
  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  plan.history_begin = std::min(tile->end - length_, feedback.t);  // eq. WIN-4
  plan.shift_time = to_seconds(step_);
  plan.partial = tile->partial;
  return plan;
}

}  // namespace aslio::plugins
