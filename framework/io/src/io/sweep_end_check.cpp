#include "sweep_end_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace aslio::io {

namespace {

constexpr std::size_t kLeast = 3;     // messages to judge by
constexpr TimeNs kSame = 10'000;      // two clocks that differ by less are one [ns]
constexpr double kBeyondShare = 0.3;  // of a sweep: less may be the clock of the IMU

TimeNs median(std::vector<TimeNs> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void SweepEndCheck::add(const LidarPacket& packet, TimeNs header, TimeNs arrival) {
  if (decided() || packet.points.empty()) return;
  const auto last = std::max_element(packet.points.begin(), packet.points.end(),
                                     [](const TimedPoint& a, const TimedPoint& b) { return a.t < b.t; });
  beyond_.push_back(last->t - arrival);
  lags_.push_back(std::abs(arrival - header));
}

std::string SweepEndCheck::doubt() const {
  if (beyond_.size() < kLeast || median(lags_) < kSame) return {};
  const TimeNs beyond = median(beyond_);
  if (to_seconds(beyond) <= kBeyondShare * to_seconds(sweep_period_)) return {};
  return fmt::format(
      "sweeps end {:.3f} s after their messages were recorded, by the clock of the IMU. The header stamp looks like "
      "that "
      "of the end of the sweep: set `lidar_stamp: end`, or correct a clock by `lidar_time_offset`",
      to_seconds(beyond));
}

}  // namespace aslio::io
