#pragma once
/// A rectangular room seen from the inside at rest, and the windows of an estimator that looks at it.

#include <algorithm>
#include <cmath>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::test {

inline constexpr TimeNs kRoomEpoch = 1'700'000'000 * kSecond;
inline constexpr TimeNs kTenth = kSecond / 10;

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

/// The room from a sensor that turns evenly: at the origin, in the attitude Exp(rate s) s seconds after kRoomEpoch.
struct TurningRoom {
  Vec3 rate = Vec3::Zero();        ///< true [rad/s]
  Vec3 gyro_error = Vec3::Zero();  ///< share of the rate that the gyro reads too much, per axis
  Vec3 drift = Vec3::Zero();       ///< true velocity [m/s]

  Pose at(TimeNs t) const {
    const double s = to_seconds(t - kRoomEpoch);
    return {exp_so3(s * rate), s * drift};
  }
};

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
    window.imu_read_at_end = true;
  }
  RoomWindow(TimeNs begin, TimeNs length, const TurningRoom& motion, std::uint32_t sequence, int points = 3000) {
    for (int i = 0; i <= 20; ++i) {
      const TimeNs t = begin + i * length / 20;
      const Vec3 force = motion.at(t).R.transpose() * Vec3(0, 0, kStandardGravity);
      imu.push_back({t, (Vec3::Ones() + motion.gyro_error).cwiseProduct(motion.rate), force});
    }
    const auto directions = all_around(points);
    for (int i = 0; i < points; ++i) {
      // Directions in an order that mixes early and late points.
      const Vec3& d = directions[static_cast<std::size_t>(i * 1009L % points)];
      TimedPoint point;
      point.t = begin + (i + 1) * length / points;
      const Pose pose = motion.at(point.t);
      const Vec3 p = wall_distance(pose.p, pose.R * d) * d;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.index = static_cast<std::uint32_t>(i);
      fresh.push_back(point);
    }
    window.plan.history_begin = window.plan.fresh_begin = begin;
    window.plan.end = begin + length;
    window.sequence = sequence;
    window.fresh = fresh;
    window.imu = imu;
    window.imu_read_at_end = true;
  }
  RoomWindow(const RoomWindow&) = delete;

  std::vector<ImuSample> imu;
  std::vector<TimedPoint> fresh;
  Window window;
};

/// Names equal parts of its window (WindowPlan::cuts).
inline void cut(RoomWindow& room, int parts) {
  WindowPlan& plan = room.window.plan;
  plan.cut_count = static_cast<std::uint32_t>(parts);
  for (int i = 1; i <= parts; ++i) {
    plan.cuts[static_cast<std::size_t>(i - 1)] = plan.fresh_begin + (plan.end - plan.fresh_begin) * i / parts;
  }
}

}  // namespace aslio::test
