#pragma once

#include <cstdint>
#include <vector>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Rooms joined by narrow doorways and a stairwell, for sensors that see all round.
struct DoorwayParams {
  std::int64_t seed = 1;        ///< of the layout and the clutter
  double room_length = 5;       ///< between two doors on a straight part of the route, about [m]
  double door_min = 0.9;        ///< width of the doorways, drawn for each [m]
  double door_max = 1.0;        ///< [m]
  double height = 2.7;          ///< of the rooms' ceilings [m]
  std::int64_t stairwells = 1;  ///< beside the rooms, where there is room for them
  double clutter = 1;           ///< things on the walls: 0 none, 1 usual
  static void describe(config::Binder& b, DoorwayParams& params);
};

/// Throws ConfigError when an edge of the route is not parallel to an axis.
World build_doorway(const DoorwayParams& params, const Route& route, double scale);

/// Where the route passes doors: the world is narrower there [m].
std::vector<Vec2> doorway_doors(const DoorwayParams& params, const Route& route);

}  // namespace aslio::simulator
