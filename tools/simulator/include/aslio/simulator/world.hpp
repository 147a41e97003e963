#pragma once
/// What surrounds the sensor and does not move. One header per kind in worlds/.

#include <vector>

#include "aslio/simulator/climb.hpp"
#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// Builders take the route (already scaled: positions scale, sizes such as widths and heights do not) and keep their
/// surfaces 0.6 m away from it at heights from 0.2 to 2.2 m above the ground (0.35 m where it passes a door). Equal
/// arguments give equal bits.
struct World {
  Mesh mesh;
  Ground ground;  ///< the mesh has this height where the route goes, to 1 cm; on steps to the height of a step
  std::vector<Climb> climbs = {};  ///< flights that lead over each other; empty: `ground` is all
};

}  // namespace aslio::simulator
