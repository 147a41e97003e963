#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "aslio/core/time.hpp"

namespace aslio::stream {

/// Values ordered by their member `t`; equal times keep the order of arrival. Appending and forgetting are O(1)
/// amortised: what was forgotten is compacted away once it is half of the storage, and the storage is reused.
template <class T>
class TimeOrdered {
 public:
  bool empty() const { return head_ == values_.size(); }
  std::size_t size() const { return values_.size() - head_; }
  const T& front() const { return values_[head_]; }
  const T& back() const { return values_.back(); }
  std::span<const T> all() const { return std::span<const T>(values_).subspan(head_); }

  /// Number of values with time <= t.
  std::size_t count_until(TimeNs t) const {
    const auto first = values_.begin() + static_cast<std::ptrdiff_t>(head_);
    const auto later = [](TimeNs limit, const T& value) { return limit < value.t; };
    return static_cast<std::size_t>(std::upper_bound(first, values_.end(), t, later) - first);
  }

  /// Values with time in (begin, end].
  std::span<const T> range(TimeNs begin, TimeNs end) const {
    if (end <= begin) return {};
    const std::size_t from = count_until(begin);
    return all().subspan(from, count_until(end) - from);
  }

  /// Adds values that are themselves in time order. An append where they are not older than back(), else a merge from
  /// the end that moves only the values that are newer than `sorted`.
  void merge(std::span<const T> sorted) {
    if (empty() || sorted.empty() || sorted.front().t >= back().t) {
      values_.insert(values_.end(), sorted.begin(), sorted.end());
      return;
    }
    std::size_t old_left = values_.size(), new_left = sorted.size();
    values_.resize(old_left + new_left);
    for (std::size_t to = values_.size(); new_left > 0;) {
      const bool take_old = old_left > head_ && values_[old_left - 1].t > sorted[new_left - 1].t;
      values_[--to] = take_old ? values_[--old_left] : sorted[--new_left];
    }
  }

  /// Forgets the `count` oldest values. Pre: count <= size().
  void forget(std::size_t count) {
    head_ += count;
    if (head_ < values_.size() - head_) return;
    values_.erase(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
  }

 private:
  std::vector<T> values_;
  std::size_t head_ = 0;
};

}  // namespace aslio::stream
