#pragma once

#include <optional>
#include <string>

#include "aslio/pipeline/update_record.hpp"

namespace aslio::pipeline {

/// When and why a run stopped being usable.
struct Divergence {
  TimeNs t = 0;
  std::string reason;
};

/// Follows the health of a run from update to update. An update is refused when its step was not accepted.
///   initialising -> ok          with the first accepted update; -> lost when the map is still empty after max_silence
///   ok -> degraded              after a refused update; -> ok after kRecovered accepted ones in a row
///   ok -> degraded              also while the accelerometer's bias is beyond kMaxAccBias: no sensor has such a bias,
///   but a
///                               filter that follows moving things or a wrong start explains its motion with one
///   degraded -> lost            after more than max_silence of refused updates (which also ends the run as diverged)
class Tracking {
 public:
  Tracking(double max_speed, double max_silence) : max_speed_(max_speed), max_silence_(to_ns(max_silence)) {}

  /// Takes the outcome of an update over the fresh data of [begin, end].
  void observe(const Update& update, TimeNs begin, TimeNs end);

  TrackingStatus status() const { return status_; }
  const std::optional<Divergence>& divergence() const { return divergence_; }

 private:
  void diverge(TimeNs t, std::string reason);
  void be_silent(TimeNs begin, TimeNs end);

  static constexpr int kRecovered = 5;
  static constexpr double kMaxAccBias = 1.5;  // [m/s^2]
  double max_speed_;
  TimeNs max_silence_;
  TrackingStatus status_ = TrackingStatus::initialising;
  int accepted_in_a_row_ = 0;
  TimeNs silence_ = 0;   ///< of the refused updates in a row, without gaps in the data
  TimeNs last_end_ = 0;  ///< of the last of them
  std::optional<Divergence> divergence_;
};

}  // namespace aslio::pipeline
