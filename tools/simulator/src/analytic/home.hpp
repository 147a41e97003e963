#pragma once
/// The one scene and walk of the analytic world.

#include <vector>

#include "aslio/simulator/boxes.hpp"
#include "aslio/simulator/walk.hpp"

namespace aslio::simulator::home {

/// Length of the walk at duration scale 1 [s].
inline constexpr double kDuration = 20;

/// A room of 12 x 8 x 3 m with furniture, two doors to a corridor, and a second room across it.
std::vector<Box> solids();
/// Once round through both doors, with three sharp turns and a look into the second room; stands still for the first
/// and the last second.
Walk walk(double time_scale);
/// Two people, `t` seconds after the start.
std::vector<Box> people(double t);

}  // namespace aslio::simulator::home
