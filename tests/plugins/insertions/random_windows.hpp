#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::test {

/// Window number `sequence`.
inline Window window_of(std::uint32_t sequence, TimeNs history_begin, TimeNs fresh_begin, TimeNs end) {
  Window window;
  window.sequence = sequence;
  window.plan.history_begin = history_begin;
  window.plan.fresh_begin = fresh_begin;
  window.plan.end = end;
  return window;
}

/// Updates of random length over windows of random reach, with gaps in the data, refused steps, updates without points,
/// and several points of one time.
class RandomWindows {
 public:
  static constexpr TimeNs kMs = 1'000'000;

  explicit RandomWindows(std::uint64_t seed) : random_(seed) {}

  void next() {
    Window& w = window;
    ++w.sequence;
    w.plan.fresh_begin = w.plan.end;
    w.plan.end += one_in(12) ? uniform(100, 600) * kMs : uniform(1, 60) * kMs;
    w.plan.history_begin = one_in(5) ? w.plan.fresh_begin : w.plan.fresh_begin - uniform(0, 120) * kMs;
    points_.clear();
    const TimeNs data_begin = std::max(w.plan.fresh_begin, w.plan.end - 60 * kMs);  // before it: a gap
    for (TimeNs t = data_begin + uniform(1, 3) * kMs; t <= w.plan.end && !empty_; t += uniform(0, 4) * kMs) {
      points_.push_back({.p_W = 20.0 * Vec3(unit(), unit(), unit()), .t = t});
    }
    empty_ = one_in(15);
    others_.assign(points_.size() + 3, {.p_W = Vec3(0, 0, 0), .t = -1});
    update = Update{};
    update.map_points = points_;
    update.match_points = others_;
    update.overlap_points = others_;
    update.accepted = !one_in(6);
    update.insert = update.accepted || one_in(3);
    if (w.sequence > 2) update.status = update.accepted ? UpdateStatus::ok : UpdateStatus::few_matches;
    update.prior.p = Vec3(0.8 * w.sequence + unit(), unit(), unit());
    update.state = update.prior;
    if (update.accepted) update.state.p += 0.1 * Vec3(unit(), unit(), unit());
  }

  Window window;
  Update update;

 private:
  TimeNs uniform(TimeNs low, TimeNs high) {
    return low + static_cast<TimeNs>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  bool one_in(std::uint64_t n) { return random_() % n == 0; }

  std::mt19937_64 random_;
  bool empty_ = false;
  std::vector<WorldPoint> points_, others_;
};

}  // namespace aslio::test
