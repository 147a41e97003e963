#pragma once
/// What surrounds the sensor and does not move. One header per kind in worlds/.

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// Builders take the route (already scaled: positions scale, sizes such as widths and heights do not) and keep their
/// surfaces 0.6 m away from it at heights from 0.2 to 2.2 m above the ground (0.35 m where it passes a door). Equal
/// arguments give equal bits.
struct World {
  Mesh mesh;
  Ground ground;  ///< the mesh has this height, to 1 cm, where the route goes
};

}  // namespace aslio::simulator
