#include "aslio/pipeline/tracking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace aslio::pipeline {

Tracking::Tracking(const TrackingLimits& limits, double sweep_period)
    : limits_(limits),
      max_silence_(to_ns(limits.max_silence)),
      no_gap_(std::max(kSecond / 10, to_ns(1.5 * sweep_period))) {}

void Tracking::diverge(TimeNs t, bool may_restart, std::string reason) {
  // One that goes on although it is lost, as a test may, is lost once.
  if (!lost()) losses_.push_back({t, std::move(reason)});
  status_ = TrackingStatus::lost;
  may_restart_ = may_restart;
}

void Tracking::observe_gap(TimeNs begin, TimeNs end) {
  if (end - begin <= to_ns(limits_.max_gap)) return;
  diverge(end, true,
          fmt::format("no points for {:.2f} s, longer than max_gap {:g} s", to_seconds(end - begin), limits_.max_gap));
}

void Tracking::observe_silent_imu(TimeNs t) {
  diverge(t + 1, true, fmt::format("no IMU data for more than max_gap {:g} s from then on", limits_.max_gap));
}

void Tracking::observe_clock_jump(TimeNs t, TimeNs by) {
  diverge(
      t + 1, true,
      fmt::format("the clock of the sensors jumped {} by {:.1f} s; later stamps are moved {} by as much, so that time "
                  "goes on",
                  by < 0 ? "back" : "ahead", std::abs(to_seconds(by)), by < 0 ? "ahead" : "back"));
}

void Tracking::observe_alarm(TimeNs t, std::string reason) {
  if (!lost()) diverge(t, true, std::move(reason));
}

void Tracking::restart(TimeNs t) {
  losses_.back().restarted = t;
  status_ = TrackingStatus::recovering;
  accepted_in_a_row_ = 0;
  silence_ = open_ = 0;
  unread_ = 0;
  begin(t);
}

void Tracking::observe(const Update& update, TimeNs begin, TimeNs end, bool without_view, bool unread) {
  // A gap in the data is no fault of the estimator, wherever it lies among refused windows.
  const bool without_gap = last_end_ > kTimeMin && begin - last_end_ <= no_gap_;
  const TimeNs length = end - (without_gap ? last_end_ : begin);
  last_end_ = end;
  const NavState& s = update.state;
  if (!s.R.allFinite() || !s.p.allFinite() || !s.v.allFinite() || !s.b_w.allFinite() || !s.b_a.allFinite()) {
    return diverge(end, ever_accepted_, "the state is not finite");
  }
  if (const double speed = s.v.norm(); speed > limits_.max_speed) {
    return diverge(end, ever_accepted_,
                   fmt::format("the speed is {:.2f} m/s, above max_speed {:g} m/s", speed, limits_.max_speed));
  }
  if (update.status == UpdateStatus::initialising) {
    // One window builds the map. A map that stays empty gets no points, and nothing will ever be registered.
    silence_ += length;
    if (silence_ > max_silence_) {
      diverge(end, ever_accepted_,
              fmt::format("the map is still empty after {:.2f} s: no point passed the samplers (range limits?), or "
                          "insertion 'on_exit' holds them in a longer window",
                          to_seconds(silence_)));
    }
    return;
  }
  if (update.accepted) {
    silence_ = 0;
    ever_accepted_ = true;
    if (drifts_unread(length, unread, update.unobservable_direction())) {
      return diverge(end, true,
                     "the IMU gave no data, and the points left a direction open before tracking recovered: the "
                     "distance travelled is not known");
    }
    if (unread || s.b_a.norm() > kMaxAccBias) {
      accepted_in_a_row_ = 0;
      status_ = TrackingStatus::degraded;
      return;
    }
    ++accepted_in_a_row_;
    const bool was_well = status_ == TrackingStatus::initialising || status_ == TrackingStatus::ok;
    status_ = was_well || accepted_in_a_row_ >= kRecovered ? TrackingStatus::ok : TrackingStatus::recovering;
    return;
  }
  silence_ += length;
  if (!without_view || silence_ > kBlink) {
    accepted_in_a_row_ = 0;
    status_ = TrackingStatus::degraded;
  }
  if (silence_ > max_silence_) {
    diverge(
        end, true,
        fmt::format("no accepted update for {:.2f} s (last refusal: {})", to_seconds(silence_), name(update.status)));
  }
}

bool Tracking::drifts_unread(TimeNs length, bool unread, bool open) {
  if (unread) {
    unread_ = kSecond;
  } else {
    unread_ = status_ == TrackingStatus::ok ? 0 : std::max<TimeNs>(unread_ - length, 0);
  }
  open_ = unread_ > 0 && open ? open_ + length : 0;
  return open_ > kOpenWhileUnread;
}

}  // namespace aslio::pipeline
