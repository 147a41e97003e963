#pragma once
/// Things that stand in rooms and hang on walls.

#include "aslio/simulator/random.hpp"
#include "worlds/floor_plan.hpp"

namespace aslio::simulator::indoor {

/// Furniture for a room of `area`, where there is room for it: desks, chairs, cupboards, shelves, plants.
void furnish(MeshBuilder& builder, Site& site, RandomStream& random, const Rect& area);

/// Skirting, and things on and before the wall: notice boards, radiators, pipes, extinguishers, cupboards, pillars.
/// `density` 1 is as usual, 0 a bare wall.
void dress_wall(MeshBuilder& builder, Site& site, RandomStream& random, const WallFace& face, double density);
/// Every wall that stands on the floor.
void dress_walls(MeshBuilder& builder, Site& site, std::uint64_t seed, double density);

/// Lamps and, where it is high enough, beams under the ceiling along a corridor, [begin, end] of a run.
void dress_ceiling(MeshBuilder& builder, const PlanGrid& grid, RandomStream& random, const Run& run, double half_width,
                   double height);

/// Rows of lamps under the ceiling of a room.
void hang_lamps(MeshBuilder& builder, const PlanGrid& grid, const Rect& area, double height);

/// Each in the frame of the placement: x along its width from 0, y out of the wall from 0.
void add_desk(MeshBuilder& builder, RandomStream& random, double width, double depth);
void add_chair(MeshBuilder& builder, const Vec2& at, double yaw);
void add_plant(MeshBuilder& builder, RandomStream& random, const Vec2& at, double radius, double height);

}  // namespace aslio::simulator::indoor
