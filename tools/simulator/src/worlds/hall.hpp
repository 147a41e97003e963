#pragma once
/// The storey of an underground garage.

#include <cstdint>
#include <vector>

#include "worlds/floor_plan.hpp"
#include "worlds/plot.hpp"

namespace aslio::simulator::outdoor {

/// Level storey with its floor at height 0 of the placement in which it is built.
struct Hall {
  /// A gap in the wall of the side with the smallest x.
  struct Gate {
    double from = 0, to = 0, height = 2.6;  ///< along y [m]
  };
  indoor::Rect area;
  double height = 2.9;            ///< of the ceiling [m]
  double grid_x = 8, grid_y = 6;  ///< between pillars [m]
  double parked = 0.6;            ///< share of the bays with a vehicle in them
  double clutter = 1;             ///< things on walls, ceiling and floor: 0 none, 1 usual
  std::vector<Gate> gates;
};

/// Adds floor, walls, ceiling with beams and pipes, pillars, bays, vehicles and what hangs on walls. The aisles are
/// where the route goes: `route` is in the frame of the placement.
void build_hall(MeshBuilder& builder, const Hall& hall, const Route& route, std::uint64_t seed);

/// Way of `length` down to a gate of the hall, from the outside at height `rise`, closed by a roller door there.
void build_ramp(MeshBuilder& builder, const Hall& hall, const Hall::Gate& gate, double length, double rise);

}  // namespace aslio::simulator::outdoor
