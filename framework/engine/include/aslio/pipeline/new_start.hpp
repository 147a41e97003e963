#pragma once
/// Where a run goes on after it was lost (docs/equations.md INI-5).

#include <algorithm>
#include <optional>

#include "aslio/pipeline/initialiser.hpp"

namespace aslio::pipeline {

/// What a run that was lost still knows.
struct LastKnown {
  TimeNs lost = 0;  ///< data before this moment are no part of a new start
  Pose pose;        ///< T_W_I of the last state that could be believed
  /// The state of the estimator, from which the IMU may be followed; nothing, if it cannot be believed.
  std::optional<NavState> state;
  TimeNs accepted = 0;      ///< end of the last update that was accepted
  double max_speed = 30.0;  ///< what is dead-reckoned beyond it cannot be [m/s]
};

/// The search for a new first state, in the data after the loss. What it finds depends on the data alone, not on how
/// much of it has arrived when it is asked: it goes on where it stood. (But where IMU data
/// come more than 5 s after their points, which are kept no longer: skip().)
class NewStart {
 public:
  /// Dead reckoning over more than this is forgotten [ns].
  static constexpr TimeNs kLongestReckoning = 30 * kSecond;

  NewStart(const LastKnown& known, const InitialisationParams& params, const SensorModel& sensor)
      : known_(known), params_(params), sensor_(sensor), from_(known.lost) {}

  /// Nothing while the data that have arrived do not suffice. Acceleration that cannot be gravity is no error: later
  /// data is taken. `estimator`: the one that was lost, as it was then. Pre: the stream keeps the points from
  /// searched_until() on, and the IMU data from keep_imu_from() on.
  std::optional<Initialisation> find(const stream::MeasurementStream& stream, const Estimator& estimator);

  /// Nothing is searched up to `t`.
  void skip(TimeNs t) { from_ = std::max(from_, t); }
  /// The new start is later than this.
  TimeNs searched_until() const { return from_; }
  /// IMU data that dead reckoning, or the search, may still ask for.
  TimeNs keep_imu_from() const;

 private:
  std::optional<NavState> reckoned(const stream::MeasurementStream& stream, const Estimator& estimator, TimeNs t) const;

  LastKnown known_;
  InitialisationParams params_;
  SensorModel sensor_;
  TimeNs from_;
};

}  // namespace aslio::pipeline
