#pragma once
/// House fronts that may be curved, with recessed windows and arched doors.

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/random.hpp"

namespace aslio::simulator::outdoor {

/// The placement's x runs along the front from its middle, y into the house, z up from the foot of the front.
struct FrontShape {
  double width = 6, depth = 8;  ///< of the house [m]
  double bow = 0;             ///< the middle of the front stands out of the line between its ends by this, or back [m]
  int floors = 2;             ///< above the ground floor
  double floor_height = 2.8;  ///< [m]
  bool arcade = false;        ///< the ground floor is open between round columns
  double below = 1.5;         ///< the walls reach this far below the foot [m]

  double height() const { return (floors + 1) * floor_height; }
};

/// Largest that the front stands out of the line between its ends [m].
inline double front_reach(const FrontShape& shape) { return shape.bow > 0 ? shape.bow : 0; }
/// Front, the other three walls, cornice and roof.
void add_old_house(MeshBuilder& builder, RandomStream& random, const FrontShape& shape);

}  // namespace aslio::simulator::outdoor
