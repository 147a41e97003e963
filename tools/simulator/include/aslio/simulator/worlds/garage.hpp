#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Underground garage: pillars on an 8 x 6 m grid, beams and pipes under the ceiling, parked cars, a ramp, views of
/// 60-80 m.
struct GarageParams {
  std::int64_t seed = 1;              ///< of the layout and the clutter
  double margin = 20;                 ///< from the route to the walls [m]; does not scale
  double height = 2.9;                ///< of the ceiling [m]
  double pillar_x = 8, pillar_y = 6;  ///< between pillars [m]
  double parked = 0.6;                ///< share of the bays with a vehicle in them
  double clutter = 1;                 ///< things on walls, ceiling and floor: 0 none, 1 usual
  static void describe(config::Binder& b, GarageParams& params);
};

/// Edges of the route along x are aisles when they are three times `pillar_y` apart.
World build_garage(const GarageParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
