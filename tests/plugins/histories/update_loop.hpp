#pragma once

#include <algorithm>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::test {

inline constexpr TimeNs kMs = 1'000'000;
inline constexpr TimeNs kFrame = 100 * kMs;

/// Plays updates of a window of 100 ms: one point every ms, all of them matched with a residual of 1 cm.
class UpdateLoop {
 public:
  explicit UpdateLoop(HistoryPolicy& policy) : policy_(policy) {
    raw_.reserve(1000);
    points_.reserve(1000);
    matches_.reserve(1000);
  }

  /// The next window, `shift` long: returns its history, then commits its points.
  HistorySelection step(TimeNs shift, bool accepted = true) {
    begin(shift);
    const HistorySelection selection = policy_.select(window);
    selected.assign(selection.points.begin(), selection.points.end());
    if (accepted) {
      policy_.commit(window, update());
    } else {
      policy_.reset();
    }
    return selection;
  }
  void begin(TimeNs shift) {
    window.plan.fresh_begin = now_;
    now_ += shift;
    window.plan.end = now_;
    window.plan.history_begin = std::min(now_ - kFrame, window.plan.fresh_begin);
    ++window.sequence;
    raw_.clear();
    points_.clear();
    matches_.clear();
    for (TimeNs t = window.plan.fresh_begin + kMs; t <= now_; t += kMs) {
      raw_.push_back({.t = t});
      points_.push_back({.p_W = Vec3(to_seconds(t), 1, 2), .t = t, .range = 7});
      matches_.push_back({.accepted = true, .residual = -0.01f, .matched = true});
    }
    window.fresh = raw_;
  }
  Update update() const {
    Update u;
    u.match_points = points_;
    u.matches = matches_;
    return u;
  }

  Window window;
  std::vector<HistoryPoint> selected;  ///< of the last step
  std::vector<MatchRecord> matches_;

 private:
  HistoryPolicy& policy_;
  TimeNs now_ = 0;
  std::vector<TimedPoint> raw_;
  std::vector<WorldPoint> points_;
};

}  // namespace aslio::test
