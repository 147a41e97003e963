#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Approach to a garage, 60 m x 3 m with bare smooth walls down a ramp, no pillars or doors in its first 25 m, then the
/// garage: degenerate along its axis.
struct ApproachParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  double length = 60;     ///< of the way to the garage [m]; scales
  double width = 3;       ///< of the way [m]
  double height = 2.6;    ///< of the ceiling over the way [m]
  double bare = 25;       ///< first part of the way without pilasters and doors [m]; scales
  double drop = 3;        ///< from the start down to the garage [m]; scales
  double margin = 18;     ///< from the route to the walls of the garage [m]
  double parked = 0.6;    ///< share of the bays with a vehicle in them
  static void describe(config::Binder& b, ApproachParams& params);
};

/// The way follows the first edge of the route. Throws ConfigError when the route has a point beside the way.
World build_approach(const ApproachParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
