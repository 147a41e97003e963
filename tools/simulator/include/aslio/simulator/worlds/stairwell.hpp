#pragma once

#include <cstdint>
#include <vector>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Stairwell of several storeys with half-turn landings: a walk from a corridor at the bottom up to one at the top and
/// back down. Its lengths are sizes: they do not scale.
struct StairwellParams {
  std::int64_t seed = 1;       ///< of the clutter, and of the doors on the way
  std::int64_t storeys = 3;    ///< that the walk climbs
  double storey_height = 3.3;  ///< from floor to floor [m]
  double width = 1.5;          ///< of a flight [m]
  double gap = 0.2;            ///< between the flights [m]
  double tread = 0.28;         ///< depth of a step [m]
  double corridor = 6;         ///< from the stairs to where the walk begins and turns round [m]
  double clutter = 1;          ///< things on the walls: 0 none, 1 usual
  static void describe(config::Binder& b, StairwellParams& params);
};

/// The route that the stairs need, from a start at the origin along x: up the flights, round in the top corridor, down.
std::vector<Vec2> stairwell_route(const StairwellParams& params);

/// Throws ConfigError when the scale is not 1 or the route is not that of stairwell_route, moved and turned (to 1 cm).
World build_stairwell(const StairwellParams& params, const Route& route, double scale);

/// Where the walk passes doors, from the bottom up, with the height of their floors [m].
std::vector<Vec3> stairwell_doors(const StairwellParams& params, const Route& route);

}  // namespace aslio::simulator
