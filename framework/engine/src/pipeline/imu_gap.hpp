#pragma once

#include <algorithm>
#include <span>

#include "aslio/core/measurement.hpp"

namespace aslio::pipeline {

/// Two samples of the IMU further apart are a gap, over which nothing is dead-reckoned or averaged [ns]. A fixed
/// length: one that goes by the usual step would depend on the samples that have arrived.
inline constexpr TimeNs kImuGap = kSecond / 4;

inline bool is_gap(const ImuSample& a, const ImuSample& b) { return b.t - a.t > kImuGap; }

/// At least one interval, and none of them a gap.
inline bool can_be_reckoned(std::span<const ImuSample> imu) {
  return imu.size() >= 2 && std::adjacent_find(imu.begin(), imu.end(), is_gap) == imu.end();
}

}  // namespace aslio::pipeline
