#pragma once
/// A rectangular room seen from the inside at rest, and the windows of an estimator that looks at it.

#include <algorithm>
#include <cmath>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::test {

inline constexpr TimeNs kRoomEpoch = 1'700'000'000 * kSecond;

/// Distance from `origin` along `direction` to the walls of the room [-4, 4] x [-3, 3] x [-1.5, 1.5].
inline double wall_distance(const Vec3& origin, const Vec3& direction) {
  const Vec3 half(4, 3, 1.5);
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < 1e-12) continue;
    nearest = std::min(nearest, (std::copysign(half[axis], direction[axis]) - origin[axis]) / direction[axis]);
  }
  return nearest;
}

/// `count` directions spread evenly over the sphere.
inline std::vector<Vec3> all_around(int count) {
  std::vector<Vec3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, angle = 2.399963229728653 * i;
    directions.emplace_back(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
  }
  return directions;
}

/// Points of the walls in W.
inline std::vector<WorldPoint> wall_points(int count) {
  std::vector<WorldPoint> points;
  for (const Vec3& d : all_around(count)) points.push_back({.p_W = wall_distance(Vec3::Zero(), d) * d});
  return points;
}

/// A window of `length` [ns] that measures the room from the fixed pose `T_W_I`; the sensor frame is the IMU frame.
class RoomWindow {
 public:
  RoomWindow(TimeNs begin, TimeNs length, const Pose& T_W_I, std::uint32_t sequence, int points = 1000) {
    for (int i = 0; i <= 20; ++i) {
      const Vec3 force = T_W_I.R.transpose() * Vec3(0, 0, kStandardGravity);
      imu.push_back({begin + i * length / 20, Vec3::Zero(), force});
    }
    const auto directions = all_around(points);
    for (int i = 0; i < points; ++i) {
      const Vec3& d = directions[static_cast<std::size_t>(i)];
      const Vec3 p = wall_distance(T_W_I.p, T_W_I.R * d) * d;
      TimedPoint point;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.t = begin + (i + 1) * length / points;
      point.index = static_cast<std::uint32_t>(i);
      fresh.push_back(point);
    }
    window.plan.history_begin = window.plan.fresh_begin = begin;
    window.plan.end = begin + length;
    window.sequence = sequence;
    window.fresh = fresh;
    window.imu = imu;
  }
  RoomWindow(const RoomWindow&) = delete;

  std::vector<ImuSample> imu;
  std::vector<TimedPoint> fresh;
  Window window;
};

}  // namespace aslio::test
