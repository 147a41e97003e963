#pragma once
/// The clock of a topic's stamps, as the times of recording show it.

#include <optional>
#include <span>
#include <vector>

#include "aslio/core/time.hpp"
#include "aslio/io/message_reader.hpp"

namespace aslio::io {

class StampClock {
 public:
  void add(TimeNs stamp, TimeNs recorded);
  /// By all that was added.
  void judge();

  /// Median of stamp - time of recording [ns]. Nothing before it is judged, and where most messages are not near it:
  /// then the times of recording, all alike after a conversion or those of a replay at another speed, tell nothing.
  std::optional<TimeNs> offset() const { return offset_; }
  /// A stamp so far from its time of recording is damaged.
  bool far_off(TimeNs stamp, TimeNs recorded) const {
    return far_ahead(stamp, recorded) || far_behind(stamp, recorded);
  }
  bool far_ahead(TimeNs stamp, TimeNs recorded) const { return offset_ && stamp - recorded > *offset_ + kFar; }
  /// The first stamp or, where that is far off, what it should have been. Pre: one was added.
  TimeNs begin() const;

 private:
  static constexpr TimeNs kFar = 5 * kSecond;
  bool far_behind(TimeNs stamp, TimeNs recorded) const { return offset_ && stamp - recorded < *offset_ - kFar; }

  TimeNs first_stamp_ = 0, first_recorded_ = 0;
  std::vector<TimeNs> offsets_;
  std::optional<TimeNs> offset_;
};

/// LiDAR messages by which the clock of their stamps is judged.
inline constexpr std::size_t kClockMessages = 5;

/// Of the first messages of some connections, which the reader selects for it.
StampClock judge_clock(MessageReader& reader, std::span<const std::uint32_t> ids, std::size_t messages);

}  // namespace aslio::io
