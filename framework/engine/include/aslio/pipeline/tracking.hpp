#pragma once

#include <optional>
#include <string>
#include <vector>

#include "aslio/pipeline/update_record.hpp"

namespace aslio::pipeline {

/// When and why a run stopped being usable, and when it started again (nothing: it did not).
struct Divergence {
  TimeNs t = 0;
  std::string reason;
  std::optional<TimeNs> restarted = {};
};

/// Beyond any of them a run is lost.
struct TrackingLimits {
  double max_speed = 60.0;   ///< of the state [m/s]
  double max_silence = 1.0;  ///< without an accepted update [s]
  double max_gap = 5.0;      ///< without points, or without IMU data where they are asked for [s]
};

/// Follows the health of a run from update to update. An update is refused when its step was not accepted.
///   initialising -> ok          with the first accepted update; -> lost when the map is still empty after max_silence
///   ok -> degraded              after a refused update; -> ok after kRecovered accepted ones in a row
///   ok -> degraded              also while the accelerometer's bias is beyond kMaxAccBias: no sensor has one, but a
///                               filter that follows moving things or a wrong start explains its motion with it
///   ok -> degraded              also while the IMU is silent, stuck or dead, and the points alone say how it moves
///   degraded -> lost            after more than max_silence of refused updates; and when the points leave a direction
///                               open for 0.15 s before all is well again after an IMU that read nothing
///   any -> lost                 with a state that is not finite or faster than max_speed, and after a gap of more than
///                               max_gap: dead reckoning is then off by more than what a match can make good; and with
///                               an IMU that is silent for as long, which leaves nothing to predict from; and where
///                               the clock of all sensors jumps
///   any -> lost                 by an alarm of the monitor (docs/equations.md MON-1..MON-4)
///   lost -> recovering          with a new first state, over an empty map; -> ok after kRecovered accepted updates
class Tracking {
 public:
  /// `sweep_period`: of the LiDAR [s]. Where points have no times of their own, no window begins before that long after
  /// the last one.
  Tracking(const TrackingLimits& limits, double sweep_period);

  /// The data up to `t` are no part of what follows.
  void begin(TimeNs t) { last_end_ = t; }
  /// Takes the outcome of an update over the fresh data of [begin, end]. One that was refused because hardly any points
  /// came (`without_view`) is no fault: it counts as silence alone. One without IMU readings to believe (`unread`) is
  /// good for now, and the run is degraded.
  void observe(const Update& update, TimeNs begin, TimeNs end, bool without_view = false, bool unread = false);
  /// There were no points within (begin, end). Lost, if that is too long.
  void observe_gap(TimeNs begin, TimeNs end);
  /// There are no IMU data for more than max_gap after `t`, or none ever: lost.
  void observe_silent_imu(TimeNs t);
  /// The clock of all sensors jumped by `by` [ns] after `t`: lost.
  void observe_clock_jump(TimeNs t, TimeNs by);
  /// The monitor says that the run is lost by the update that ends at `t`.
  void observe_alarm(TimeNs t, std::string reason);
  /// The run goes on from a new first state at `t`. Pre: lost.
  void restart(TimeNs t);

  TrackingStatus status() const { return status_; }
  bool lost() const { return status_ == TrackingStatus::lost; }
  /// Pre: lost. Whether a new start may help. Not after one that put nothing into the map or ran away before any update
  /// was accepted: units and range limits that are wrong at the beginning are wrong later.
  bool may_restart() const { return may_restart_; }
  /// In the order of time.
  const std::vector<Divergence>& losses() const { return losses_; }
  /// The first loss, or nullptr.
  const Divergence* divergence() const { return losses_.empty() ? nullptr : &losses_.front(); }

 private:
  void diverge(TimeNs t, bool may_restart, std::string reason);
  /// Whether the points leave a direction open soon after the IMU read nothing, so that its velocity is not known.
  bool drifts_unread(TimeNs length, bool unread, bool open);

  static constexpr int kRecovered = 5;
  static constexpr TimeNs kBlink = kSecond * 3 / 20;  ///< without a view: one empty message is no trouble
  static constexpr TimeNs kOpenWhileUnread = kSecond * 3 / 20;
  static constexpr double kMaxAccBias = 1.5;  // [m/s^2]
  TrackingLimits limits_;
  TimeNs max_silence_;
  TimeNs no_gap_;  ///< a time without data, no longer than between two messages
  TrackingStatus status_ = TrackingStatus::initialising;
  int accepted_in_a_row_ = 0;
  TimeNs silence_ = 0;          ///< of the refused updates in a row, without gaps in the data
  TimeNs last_end_ = kTimeMin;  ///< of the last update
  TimeNs unread_ = 0;           ///< for so long it counts that the IMU read nothing; not beyond all being well again
  TimeNs open_ = 0;             ///< of updates in a row that left a direction open while unread_
  bool ever_accepted_ = false, may_restart_ = false;
  std::vector<Divergence> losses_;
};

}  // namespace aslio::pipeline
