#include "topic_statistics.hpp"

#include <algorithm>

namespace aslio::io {

void TopicStatistics::add(TimeNs stamp) {
  constexpr std::size_t kMaxSteps = 4'000'000;  // 5.5 h at 200 Hz; later ones count for the gap only through the rate
  if (count_++ == 0) {
    first_ = last_ = newest_ = stamp;
    return;
  }
  if (stamp < last_) ++backward_;
  if (stamp == last_) ++repeated_;
  last_ = stamp;
  if (stamp <= newest_) return;
  if (steps_.size() < kMaxSteps) steps_.push_back(stamp - newest_);
  newest_ = stamp;
}

void TopicStatistics::finish(TopicReport& report) {
  report.messages = count_;
  report.backward = backward_;
  report.repeated = repeated_;
  if (steps_.empty()) return;
  report.largest_gap = to_seconds(*std::max_element(steps_.begin(), steps_.end()));
  const auto middle = steps_.begin() + static_cast<std::ptrdiff_t>(steps_.size() / 2);
  std::nth_element(steps_.begin(), middle, steps_.end());
  report.median_period = to_seconds(*middle);
  if (newest_ > first_) report.rate = static_cast<double>(count_ - 1) / to_seconds(newest_ - first_);
}

}  // namespace aslio::io
