#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// A path through a wood on hilly, uneven ground: round trunks that lean and taper, crowns and bushes of single leaves,
/// roots, logs and rocks. Hardly a plane in it.
struct ForestParams {
  std::int64_t seed = 1;    ///< of ground and plants
  double relief = 3;        ///< the ground rises and falls by up to this [m]
  double roughness = 0.08;  ///< of the ground beside the path, up or down [m]
  double path = 1.6;        ///< width of the path [m]; nothing stands on it
  double trees = 5;         ///< for each 100 m^2
  double lean = 6;          ///< trunks lean by up to this [deg]
  double bushes = 1;        ///< bushes and ferns: 0 none, 1 usual
  double clutter = 1;       ///< roots, logs and rocks: 0 none, 1 usual
  static void describe(config::Binder& b, ForestParams& params);
};

/// Edges of the route may have any direction.
World build_forest(const ForestParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
