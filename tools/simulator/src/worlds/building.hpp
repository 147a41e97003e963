#pragma once
/// Houses with windows in niches.

#include "aslio/simulator/random.hpp"
#include "worlds/plot.hpp"

namespace aslio::simulator::outdoor {

struct Building {
  double width = 18, depth = 11;  ///< along x and y [m]
  int storeys = 3;
  double storey = 3.2;                                                        ///< height of each [m]
  double bay = 3;                                                             ///< from window to window, about [m]
  double window_width = 1.2, window_height = 1.5, sill = 0.95, niche = 0.18;  ///< [m]
  bool gabled = false;                                                        ///< else flat with a parapet
  bool bands = false;                                                         ///< a ledge at each storey
  double balconies = 0;                                                       ///< share of the upper windows
  std::uint8_t wall = material::kPlaster;
};

Building draw_building(RandomStream& random, double width, double depth);

/// About the origin of the placement, on level ground; its walls go 2.5 m into it. Doors are on the sides towards -y
/// and +y.
void add_building(MeshBuilder& builder, RandomStream& random, const Building& building);

/// What it stands on, with ledges, steps and balconies.
Footprint footprint(const Building& building, const Placement& placement);

}  // namespace aslio::simulator::outdoor
