#include "stamp_clock.hpp"

#include <algorithm>
#include <cmath>

#include "decode/decode.hpp"

namespace aslio::io {

void StampClock::add(TimeNs stamp, TimeNs recorded) {
  if (offsets_.empty()) {
    first_stamp_ = stamp;
    first_recorded_ = recorded;
  }
  offsets_.push_back(stamp - recorded);
}

void StampClock::judge() {
  constexpr TimeNs kNear = kSecond / 2;  // messages wait for the recorder, but hardly longer
  if (offsets_.empty()) return;
  const auto middle = offsets_.begin() + static_cast<std::ptrdiff_t>(offsets_.size() / 2);
  std::nth_element(offsets_.begin(), middle, offsets_.end());
  const TimeNs median = *middle;
  const auto near = std::count_if(offsets_.begin(), offsets_.end(),
                                  [median](TimeNs offset) { return std::abs(offset - median) <= kNear; });
  if (2 * near > std::ssize(offsets_)) offset_ = median;
}

TimeNs StampClock::begin() const {
  return far_off(first_stamp_, first_recorded_) ? first_recorded_ + *offset_ : first_stamp_;
}

StampClock judge_clock(MessageReader& reader, std::span<const std::uint32_t> ids, std::size_t messages) {
  StampClock clock;
  RawMessage message;
  reader.select(ids);
  for (std::size_t i = 0; i < messages && reader.next(message); ++i) {
    if (const auto stamp = decode::header_stamp(message)) clock.add(*stamp, message.time);
  }
  clock.judge();
  return clock;
}

}  // namespace aslio::io
