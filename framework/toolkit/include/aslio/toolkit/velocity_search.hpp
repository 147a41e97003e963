#pragma once

#include <algorithm>
#include <cmath>

#include "aslio/stages/estimator.hpp"

namespace aslio {

/// The begin of a start in motion, while updates find the velocity alone (docs/equations.md INI-3). Counted in time,
/// not in windows: what a velocity can be known by is how far the view has moved. A window counts for at most 0.1 s:
/// one that spans a gap, or is that long, is still one look.
class VelocitySearch {
 public:
  void begin(const InitialState& initial) {
    initial_ = initial;
    seen_ = 0;
  }
  /// Whether the next accepted update is one of it.
  bool active() const { return initial_.mode == InitialMode::dynamic_start && seen_ < kLength; }
  /// What an accepted update over the fresh part of `plan` leaves of `state`: all but its pose and velocity is as it
  /// was at the start.
  void step(const WindowPlan& plan, NavState& state) {
    seen_ += std::min(plan.end - plan.fresh_begin, kTenth);
    state.b_w = initial_.state.b_w;
    state.b_a = initial_.state.b_a;
    state.g = initial_.state.g;
    state.S_w = initial_.state.S_w;
    state.imu_delay = initial_.state.imu_delay;
  }
  /// Standard deviation of the velocity after the last step [m/s].
  double sigma_velocity() const {
    constexpr double shrink = 0.4, least = 0.05;  // least: [m/s]
    return std::max(least, initial_.sigma_velocity * std::pow(shrink, to_seconds(seen_) / to_seconds(kTenth)));
  }

 private:
  static constexpr TimeNs kTenth = kSecond / 10;
  static constexpr TimeNs kLength = 9 * kTenth / 2;  ///< five windows of about 0.1 s

  InitialState initial_;
  TimeNs seen_ = 0;
};

}  // namespace aslio
