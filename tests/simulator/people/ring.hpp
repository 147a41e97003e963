#pragma once
/// A route and a motion round it, by hand.

#include <memory>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/walk.hpp"

namespace aslio::simulator::test {

/// 30 m x 12 m with a spur that is walked out and back from the far corner.
inline Route ring() { return Route({{0, 0}, {30, 0}, {30, 12}, {30, 20}, {30, 12}, {0, 12}}); }

/// Round a route at one speed, from rest and to rest within 1.5 m of each corner, 2 s of rest at both ends.
inline std::unique_ptr<Motion> round(const Route& route, double speed) {
  constexpr double kStart = 1.5;
  const std::vector<Vec2>& points = route.points();
  std::vector<Waypoint> waypoints{{0, points[0].x(), points[0].y(), 0, 0}, {2, points[0].x(), points[0].y(), 0, 0}};
  const auto go = [&](const Vec2& to, const Vec2& velocity, double duration) {
    waypoints.push_back({waypoints.back().t + duration, to.x(), to.y(), velocity.x(), velocity.y()});
  };
  for (std::size_t k = 1; k <= points.size(); ++k) {
    const Vec2 from = points[k - 1], to = points[k % points.size()], along = (to - from).normalized();
    go(from + kStart * along, speed * along, 2 * kStart / speed);
    go(to - kStart * along, speed * along, ((to - from).norm() - 2 * kStart) / speed);
    go(to, Vec2::Zero(), 2 * kStart / speed);
  }
  go(points[0], Vec2::Zero(), 2);
  return std::make_unique<Walk>(waypoints, std::vector<Turn>{}, Gait{}, 1.0);
}

}  // namespace aslio::simulator::test
