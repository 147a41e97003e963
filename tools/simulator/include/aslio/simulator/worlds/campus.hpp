#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Campus: streets along the route with kerbs, facades with windows, trees, parked cars, street furniture, relief.
struct CampusParams {
  std::int64_t seed = 1;                    ///< of the layout and the clutter
  double relief = 0.8;                      ///< the ground rises and falls by up to this [m]
  double street = 7;                        ///< width between the kerbs [m]; the route is its middle
  double setback_min = 2, setback_max = 8;  ///< from the pavements to the buildings [m]
  double buildings = 0.8;                   ///< share of the fronts along the streets with a building
  double trees = 1;                         ///< 1 is as usual, 0 none
  double parked = 0.45;                     ///< share of the places at the kerbs with a vehicle
  double furniture = 1;                     ///< lamps, benches, signs, hedges, fences: 1 is as usual, 0 none
  double bare_begin = 0.5;                  ///< where the stretch without features begins, share of the round
  double bare_length = 0;                   ///< of that stretch [m]; scales; 0: there is none
  double bare_width = 22;                   ///< nothing stands within this on either side of the stretch [m]
  static void describe(config::Binder& b, CampusParams& params);
};

/// Edges of the route may have any direction.
World build_campus(const CampusParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
