#pragma once
/// How fast a walk along a straight line can change its speed.

namespace aslio::simulator {

/// Changes of speed follow the quintic step: septic polynomials of the way with no acceleration or jerk at the ends.
class Pace {
 public:
  /// `speed` on long straight lines [m/s].
  explicit Pace(double speed) : speed_(speed) {}

  /// For a change between two speeds [s].
  double time(double from, double to) const;
  /// Covered meanwhile [m].
  double distance(double from, double to) const;
  /// The highest speed up to `limit` that can be had after `length` metres; `limit` where that is below `from`.
  double reachable(double from, double length, double limit) const;
  /// The highest speed between `from` at the begin and `to` at the end of `length` metres.
  double peak(double from, double to, double length) const;

 private:
  double speed_;
};

}  // namespace aslio::simulator
