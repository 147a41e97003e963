#include "windows/replay.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/toolkit/tiling.hpp"

namespace aslio::plugins {

namespace {

/// A schedule that begins later than this [ns] is of other data: all of them up to there would make one window.
constexpr TimeNs kLatestBegin = 10 * kSecond;

ReplaySchedule prepare(const ReplayWindow::Params& params) {
  if (params.file.empty()) throw ConfigError("window 'replay' needs a 'file': the updates.csv of a run, for example");
  ReplaySchedule schedule = ReplaySchedule::read(params.file);
  const std::vector<ReplaySchedule::Update> head = schedule.split(to_ns(params.warmup));
  schedule.rotate(to_ns(params.shift));
  switch (params.order) {
    case ReplayWindow::Order::recorded:
      break;
    case ReplayWindow::Order::shuffled:
      schedule.shuffle(static_cast<std::uint64_t>(params.seed));
      break;
    case ReplayWindow::Order::steady:
      schedule.steady();
      break;
    case ReplayWindow::Order::turn_rate:
      schedule.by_turn_rate();
      break;
  }
  schedule.prepend(head);
  return schedule;
}

}  // namespace

void ReplayWindow::describe(config::Binder& b, Params& p) {
  b.text("file", p.file,
         "CSV file with the end of each update in column t_ns, such as the updates.csv of a run. It may have the start "
         "of each window in window_begin_ns. The path is relative to the working directory");
  b.real("shift", p.shift, "s", {.min = -1e6, .max = 1e6},
         "moves the intervals in time, around the circle from the first update to the last");
  b.choice("order", p.order,
           {{"recorded", Order::recorded},
            {"shuffled", Order::shuffled},
            {"steady", Order::steady},
            {"turn_rate", Order::turn_rate}},
           "of the intervals between updates. recorded: that of the file. shuffled: random, each with its length and "
           "history. steady: as many of equal length. turn_rate: as many of like lengths, the shorter the faster the "
           "sensor turns (column gyro_rms_rad_s)");
  b.integer("seed", p.seed, "", {.min = 0, .max = 1e9}, "draws the order 'shuffled'");
  b.real("warmup", p.warmup, "s", {.min = 0.0, .max = 1000.0},
         "updates that end within this time of the first keep their place under any shift and order. The slow first "
         "second of sod_adaptive is not due to the overlap");
  b.real("period", p.period, "s", {.min = 1e-3, .max = 10.0},
         "time between updates, without history, once the schedule has ended");
  b.require(p.shift == 0.0 || p.order == Order::recorded || p.order == Order::shuffled, "shift",
            "moves the intervals: it does not go with order 'steady' or 'turn_rate'");
  b.require(!p.file.empty(), "file", "is missing: name a schedule, such as the updates.csv of a run");
}

ReplayWindow::ReplayWindow(const Params& params, const BuildContext& context)
    : file_(params.file),
      schedule_(prepare(params)),
      period_(to_ns(params.period)),
      reach_(schedule_.longest_history()),
      begun_(context.anew),
      anew_(context.anew) {}

void ReplayWindow::check_begin(TimeNs begin) {
  const TimeNs first = schedule_.updates().front().end, last = schedule_.updates().back().end;
  if (last <= begin) {
    throw DataError(fmt::format("{}: the schedule ends at {} ns, the data begin at {} ns: is it of this recording?",
                                file_, last, begin));
  }
  if (first - begin > kLatestBegin) {
    throw DataError(fmt::format("{}: the schedule begins at {} ns, {:.0f} s after the data: is it of this recording?",
                                file_, first, to_seconds(first - begin)));
  }
  begun_ = true;
}

std::optional<WindowPlan> ReplayWindow::next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) {
  if (exhausted(stream, feedback.t)) return std::nullopt;
  if (!begun_) check_begin(feedback.t);
  const ReplaySchedule::Update* update = schedule_.after(feedback.t);
  if (anew_ && update != nullptr && update->end - feedback.t > kLatestBegin) update = nullptr;  // not yet
  const TimeNs shift = update != nullptr ? update->end - feedback.t : period_;                  // eq. WIN-7
  const auto tile = settle(stream, {.begin = feedback.t, .shift = shift, .limit = shift});
  if (!tile) return std::nullopt;
  WindowPlan plan;
  plan.fresh_begin = feedback.t;
  plan.end = tile->end;
  // Histories rely on it that no window reaches back further than the one before, which a schedule in another order
  // may ask for, as at the seam of a shifted one.
  plan.history_begin = std::max(history_begin_, feedback.t - (update != nullptr ? update->history : 0));
  history_begin_ = plan.history_begin;
  plan.shift_time = to_seconds(shift);
  plan.partial = tile->partial;
  return plan;
}

}  // namespace aslio::plugins
