#pragma once
/// Stairs that lead over each other: the height of the walk depends on the edge it is on, not on the place alone.

#include <cstddef>
#include <memory>
#include <vector>

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::simulator {

/// What one edge of a route adds to the height, beside the ground: the height of `ground` less the one at the edge's
/// begin. It must be level near both ends of the edge, where the walk cuts the corners. All climbs of a round sum to 0.
struct Climb {
  std::size_t edge = 0;  ///< from 0
  Ground ground;
};

/// Height [m] that the climbs add `s` metres along the first round of the route.
double climbed(const Route& route, const std::vector<Climb>& climbs, double s);

/// The walk with its climbs. `walk` goes round the route and stands still at the end. `plain` is the same walk without
/// sway, and tells the edges; it is used here alone. As smooth as the walk.
std::unique_ptr<Motion> make_climbing(std::unique_ptr<Motion> walk, const Motion& plain, const Route& route,
                                      std::vector<Climb> climbs);

}  // namespace aslio::simulator
