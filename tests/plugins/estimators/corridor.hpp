#pragma once
/// A bare corridor along x, of two walls and a floor: nothing in it binds the position along x.

#include <random>
#include <vector>

#include "plugins/estimators/room.hpp"

namespace aslio::test {

struct CorridorPoint {
  Vec3 p, normal;
};

/// `count` points spread over both walls (y = -1.5, 1.5) and the floor (z = -1.5), |x| < `reach`, one after another.
inline std::vector<CorridorPoint> corridor_points(int count, double reach, std::mt19937& random) {
  std::uniform_real_distribution<double> along(-reach, reach), across(-1.4, 1.4);
  std::vector<CorridorPoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = along(random), other = across(random);
    if (i % 3 == 2) {
      points.push_back({Vec3(x, other, -1.5), Vec3::UnitZ()});
    } else {
      const double side = i % 3 == 0 ? 1.0 : -1.0;
      points.push_back({Vec3(x, 1.5 * side, other), -side * Vec3::UnitY()});
    }
  }
  return points;
}

/// A window of 0.1 s at rest at the origin of the corridor, with ranges in error by `noise` [m].
struct CorridorWindow : RoomWindow {
  CorridorWindow(std::uint32_t sequence, int points, double noise, std::mt19937& random)
      : RoomWindow(kRoomEpoch + (sequence - 2) * kTenth, kTenth, Pose{}, sequence, points) {
    std::normal_distribution<double> error(0.0, noise);
    const auto corridor = corridor_points(points, 8.0, random);
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      const Vec3 p = corridor[i].p + error(random) * corridor[i].p.normalized();
      fresh[i].x = static_cast<float>(p.x());
      fresh[i].y = static_cast<float>(p.y());
      fresh[i].z = static_cast<float>(p.z());
    }
  }
};

}  // namespace aslio::test
