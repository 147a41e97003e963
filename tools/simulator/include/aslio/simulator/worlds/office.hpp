#pragma once

#include <cstdint>
#include <vector>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// A room of given corners, before scaling [m].
struct OfficeRoom {
  double low_x = 0, low_y = 0, high_x = 5, high_y = 4;
  bool furnished = true;
  static void describe(config::Binder& b, OfficeRoom& room);
};

/// Office corridors 2-2.5 m wide along the route, rooms with doors beside them; also single rooms by coordinates
/// (quickstart).
struct OfficeParams {
  std::int64_t seed = 1;          ///< of the layout and the clutter
  double corridor_width = 2.2;    ///< each differs by up to 0.15 [m]
  double height = 2.7;            ///< of the ceiling [m]
  double room_density = 0.8;      ///< share of the places beside the corridors that have a door
  double open_doors = 0.5;        ///< share of the doors that are open
  double clutter = 1;             ///< things on the walls: 0 none, 1 usual
  std::vector<OfficeRoom> rooms;  ///< grown where the route needs it; where it enters or leaves one there is a door
  static void describe(config::Binder& b, OfficeParams& params);
};

/// Throws ConfigError when an edge of the route is not parallel to an axis.
World build_office(const OfficeParams& params, const Route& route, double scale);

/// Where the route passes doors: the world is narrower there [m].
std::vector<Vec2> office_doors(const OfficeParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
