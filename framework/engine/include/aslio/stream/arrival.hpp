#pragma once
/// What is judged of a measurement when it arrives: is its stamp plausible, how long is a usual step.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"

namespace aslio::stream {

/// Stamps may step back by this much (reordering) or ahead by this much (a pause) and are still believed; a step ahead
/// of more than kMaxStepBack once the next two measurements confirm it.
inline constexpr TimeNs kMaxStepBack = kSecond;
inline constexpr TimeNs kMaxStepAhead = 60 * kSecond;
/// Coordinates beyond this are garbage [m]; they would overflow cell indices.
inline constexpr float kMaxCoordinate = 1e5F;
/// Stamps beyond this (73 years from 0) are garbage; differences of the others cannot overflow.
inline constexpr TimeNs kMaxStamp = kTimeMax / 4;
/// Readings beyond are garbage [rad/s, m/s^2], which would overflow a filter. Counts in place of units are below, and
/// told by what they say of gravity.
inline constexpr double kMaxRate = 1e5, kMaxForce = 1e6;

/// A stamp that arithmetic can be done with.
constexpr bool sane_stamp(TimeNs t) { return t > -kMaxStamp && t < kMaxStamp; }

/// Tells a wild stamp or two, which are to be ignored, from a pause of the data, and from a clock that really jumped:
/// what three stamps in a row agree on is believed.
class JumpGuard {
 public:
  enum class Verdict {
    take,      ///< and the measurements that are held, if any, had wild stamps: drop them
    ignore,    ///< a wild stamp
    hold,      ///< a pause or a wild stamp, as the next ones will show; drop what is held already
    hold_too,  ///< with what is held already, as it agrees with that
    begin,     ///< the only measurement before had the wild stamp: forget that one and take this
    jumped,    ///< the clock: this one and the two before agree on it
  };

  explicit JumpGuard(std::string what) : what_(std::move(what)) {}

  /// Whether a measurement of [begin, end] confirms that those that are held came after a pause: take them first.
  bool confirms(TimeNs begin, TimeNs end);
  /// Whether neither reordering nor a pause, nor the pause that the held ones may be, explains a measurement of
  /// [begin, end] after `last`.
  bool implausible(TimeNs begin, TimeNs end, TimeNs last) const;
  /// Of a measurement of [begin, end] after `last`. At the third implausible stamp in a row that continues the one
  /// before, and at those that follow it: `begin` when only one measurement has been taken (`sole`), else `jumped`.
  Verdict judge(TimeNs begin, TimeNs end, TimeNs last, bool sole);
  /// Where the stamps begin that agree on a jump. Pre: the last verdict was `jumped`.
  TimeNs jumped_to() const { return first_rejected_; }
  /// Throws the DataError of a clock that jumped after `last` while the other sensor's did not.
  [[noreturn]] void fail(TimeNs last) const;
  /// What comes next is judged by itself.
  void forget();

 private:
  bool agrees_with_held(TimeNs begin, TimeNs end) const;

  std::string what_;
  int held_ = 0;         ///< measurements that wait for others that agree
  TimeNs held_end_ = 0;  ///< of the last of them
  TimeNs rejected_ = 0, first_rejected_ = 0, third_rejected_ = 0;
  int in_a_row_ = 0;
};

/// Median of the last 101 steps: O(1) memory, not disturbed by gaps, jitter and duplicates.
class StepMedian {
 public:
  void add(TimeNs step);
  /// 0 before the first step.
  TimeNs median() const { return median_; }

 private:
  std::array<TimeNs, 101> steps_{};
  std::size_t next_ = 0, count_ = 0;
  TimeNs median_ = 0;
};

/// What admitting the points of one packet found.
struct PacketFindings {
  std::size_t invalid = 0;    ///< coordinates not finite or beyond kMaxCoordinate, time beyond kMaxStamp
  std::size_t stray = 0;      ///< more than kMaxStepBack away from the body of the packet: wrapped or wrong offsets
  std::size_t reordered = 0;  ///< older than a point that came before (a stray counts as one, too)
};

/// Puts the points of packets in time order and drops the impossible ones. Keeps its scratch storage.
class PacketSorter {
 public:
  /// Post: `points` is in time order; equal times keep the order of arrival. `newest` is the time of the newest point
  /// of earlier packets (kTimeMin: none). O(n) when the points are in order already, and otherwise too (radix sort).
  PacketFindings sort(std::vector<TimedPoint>& points, TimeNs newest);

 private:
  struct Key {
    std::uint64_t t;
    std::uint32_t position;
  };
  void sort_by_time(std::vector<TimedPoint>& points);

  std::vector<Key> keys_, keys_scratch_;
  std::vector<TimedPoint> sorted_;
};

}  // namespace aslio::stream
