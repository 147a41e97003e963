#pragma once

#include <cstdint>

#include "aslio/simulator/road.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// A road between houses, or between guard rails and trees: things that repeat along it. The line that is driven is the
/// middle of the rightmost lane.
struct StreetParams {
  std::int64_t seed = 1;                    ///< of the layout
  double relief = 0.6;                      ///< the ground rises and falls by up to this [m]
  std::int64_t lanes = 1;                   ///< in each direction
  double lane = 3.5;                        ///< width of one [m]
  double median = 0;                        ///< between the directions [m]; with a guard rail on both of its edges
  double shoulder = 2.2;                    ///< beside the outer lanes [m]; vehicles park on one of 2 m and more
  double pavement = 2;                      ///< width, kerbs included [m]; 0: none, delineators in their place
  double guard_rails = 0;                   ///< share of the outer edges with a guard rail
  double houses = 0.9;                      ///< share of the fronts with a house
  double alike = 0.6;                       ///< share of the houses that are copies of the one before
  double setback_min = 1, setback_max = 4;  ///< from pavement or shoulder to the houses [m]
  double side_streets = 90;                 ///< distance of one from the next [m]; 0: none
  double lamps = 28;                        ///< distance of one post from the next [m]; 0: none
  double trees = 1;                         ///< 1 is as usual, 0 none
  double parked = 0.4;                      ///< share of the places on the shoulders with a vehicle
  double bridges = 0;                       ///< distance of one over the road from the next [m]; 0: none
  static void describe(config::Binder& b, StreetParams& params);

  /// Edges of the asphalt, left of the line that is driven [m].
  double right_edge() const { return -0.5 * lane - shoulder; }
  double left_edge() const { return (2 * static_cast<double>(lanes) - 0.5) * lane + median + shoulder; }
  /// Middles of lanes, left of the line that is driven [m]: the `k`-th in the same direction, counted from 0 at the
  /// right, and in the other one, counted from 0 at its own right (the far side).
  double lane_along(std::int64_t k) const { return static_cast<double>(k) * lane; }
  double lane_against(std::int64_t k) const { return static_cast<double>(2 * lanes - 1 - k) * lane + median; }
};

/// Reaches 120 m beyond both ends of the road.
World build_street(const StreetParams& params, const RoadLine& road);

}  // namespace aslio::simulator
