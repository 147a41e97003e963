#pragma once
/// Small recordings for the tests of the stream.

#include <cstdint>
#include <random>
#include <vector>

#include "aslio/core/measurement.hpp"

namespace aslio::test {

inline constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;

/// Integer in [low, high]; the same on every machine.
inline TimeNs pick(std::mt19937_64& random, TimeNs low, TimeNs high) {
  return low + static_cast<TimeNs>(random() % static_cast<std::uint64_t>(high - low + 1));
}

/// A point that can be recognised by `label`.
inline TimedPoint point(TimeNs t, std::uint32_t sweep = 0, float label = 0) {
  TimedPoint p;
  p.x = label;
  p.t = t;
  p.sweep_id = sweep;
  return p;
}

inline LidarPacket packet(std::uint32_t sweep, std::vector<TimedPoint> points) {
  LidarPacket out;
  out.sweep_id = sweep;
  out.stamp = points.empty() ? kEpoch : points.front().t;
  out.points = std::move(points);
  return out;
}

inline ImuSample imu(TimeNs t, double value = 0) { return {t, Vec3(value, 0, 0), Vec3(0, value, 0)}; }

/// `count` points, one each `step`, from `begin` on.
inline LidarPacket regular_packet(std::uint32_t sweep, TimeNs begin, TimeNs step, int count) {
  std::vector<TimedPoint> points;
  for (int i = 0; i < count; ++i) points.push_back(point(begin + i * step, sweep, static_cast<float>(i)));
  return packet(sweep, std::move(points));
}

}  // namespace aslio::test
