#pragma once
/// A stairwell beside a room: a flight up to a landing, one back above the flight down.

#include "worlds/floor_plan.hpp"

namespace aslio::simulator::indoor {

class Stairwell {
 public:
  static constexpr double kWidth = 2.8, kDepth = 4.6;  ///< [m]

  /// Behind the wall at `at`, the middle of its opening; `normal` points out of the room.
  Stairwell(const Vec2& at, const Vec2& normal) : at_(at), normal_(normal) {}
  /// Without its walls.
  Rect area() const { return part(-0.5 * kWidth, 0.5 * kWidth, kWall, kWall + kDepth); }
  /// The well with its opening and 1.2 m of the room before it, so that nothing hides the stairs.
  Rect kept_free() const { return part(-0.5 * kWidth, 0.5 * kWidth, -1.2, kWall + kDepth); }
  /// The opening, the well and the hole of the flight down.
  void add_to(FloorPlan& plan, double ceiling) const;
  /// x along the wall from the middle of the opening, y out of the room, both from the room's side of the wall.
  Placement frame() const { return at_wall(at_, normal_); }

 private:
  Rect part(double x0, double x1, double y0, double y1) const;
  Vec2 at_, normal_;
};

/// Steps, landings and rails.
void build_stairs(MeshBuilder& builder, Site& site, const Stairwell& stairs);

}  // namespace aslio::simulator::indoor
