#pragma once
/// From overlap to update rate: AS-LIO eqs. (7)-(8) and the echo. (WIN-1, WIN-2)

#include <cstdint>
#include <optional>

#include "aslio/core/time.hpp"

namespace aslio::plugins {

/// How the rate falls when an echo has ended.
enum class Recover : std::uint8_t {
  step,  ///< to what the latest overlap asks for, in one jump
  ramp   ///< by one segment per echo
};

/// State machine of the adaptive window. n is the number of half-window segments in a window of length L (seg_time):
/// an update comes every 2 L / n. It rises at once and falls only when its echo of n updates (2 L of stream) has run
/// out, for the continuity of motion.
class SegmentSchedule {
 public:
  /// seg_step in (0, 1]: loss of overlap per segment; n_min, n_limit: smallest and largest n, 2 <= n_min <=
  /// n_limit; without `echo` an echo lasts a single update, so that n may fall at each.
  SegmentSchedule(double seg_step, std::int64_t n_min, std::int64_t n_limit, Recover recover, bool echo = true)
      : seg_step_(seg_step),
        n_min_(n_min),
        n_max_(n_limit),
        n_limit_(n_limit),
        recover_(recover),
        holds_(echo),
        n_(n_min) {}

  /// n that an overlap in [0, 1] asks for. eq. WIN-1, AS-LIO (7), clamped to [n_min, n_limit]: n = 1 would leave a
  /// hole of L.
  std::int64_t wanted(double overlap) const;
  /// Time between updates for a window of length L [ns], rounded down. eq. WIN-2, AS-LIO (8).
  TimeNs shift(TimeNs frame_length) const { return 2 * frame_length / n_; }

  /// After each update: the overlap it measured, and the least n that other evidence asks for. An undefined overlap
  /// asks for nothing and keeps n; the echo, a stretch of stream, runs on.
  void observe(std::optional<double> overlap, std::int64_t least = 2);
  /// Before an update: the overlap predicted for coming points. Only a rise of n counts; says whether there was one.
  bool anticipate(std::optional<double> overlap);
  /// From now on n does not exceed `n` either, though n_min stays allowed.
  void limit(std::int64_t n);
  /// Back to the start: n_min (warm-up of the map).
  void restart();
  /// The next overlap decides, whatever was left of the echo (gap in the data).
  void end_echo() { echo_ = 0; }

  std::int64_t n() const { return n_; }
  /// Updates left at this n.
  std::int64_t echo() const { return echo_; }

 private:
  void arm(std::int64_t n);
  /// Updates for which the present n is held.
  std::int64_t held() const;

  double seg_step_;
  std::int64_t n_min_, n_max_;
  std::int64_t n_limit_;  ///< n_max_, or what limit() said
  Recover recover_;
  bool holds_;
  std::int64_t n_;
  std::int64_t echo_ = 1;
};

}  // namespace aslio::plugins
