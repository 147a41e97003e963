#pragma once
/// Where things may stand on open ground: not in each other, not in the way.

#include <array>
#include <vector>

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::simulator::outdoor {

/// Rectangle in the plan, turned by `yaw`.
struct Footprint {
  Vec2 centre = Vec2::Zero(), half = Vec2::Zero();  ///< [m]
  double yaw = 0;                                   ///< [rad]

  double radius() const { return half.norm(); }
  /// In order round it.
  std::array<Vec2, 4> corners() const;
  /// In the frame of the rectangle.
  Vec2 local(const Vec2& p) const;
  bool overlaps(const Footprint& other) const;
  /// To the segment from `a` to `b` [m]; 0 when they meet.
  double distance(const Vec2& a, const Vec2& b) const;
};

/// The footprint of [low, high] in a placement.
Footprint footprint(const Placement& placement, const Vec2& low, const Vec2& high);
/// Distance to the line of a route [m].
double distance(const Route& route, const Footprint& area);

class Plot {
 public:
  explicit Plot(const Route& route) : route_(&route) {}
  /// Takes the area when nothing stands there and it is at least `keep` [m] from the route.
  bool claim(const Footprint& area, double keep);
  /// Nothing will stand there.
  void reserve(const Footprint& area) { taken_.push_back(area); }
  const Route& route() const { return *route_; }

 private:
  const Route* route_;
  std::vector<Footprint> taken_;
};

}  // namespace aslio::simulator::outdoor
