#pragma once
/// A straight flight of steps: what it looks like, and how a walk climbs it.

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// In a frame with x along the flight and its first riser at x = 0. The last riser leads onto the landing.
struct Flight {
  int steps = 10;
  double tread = 0.28;              ///< depth of a step [m]
  double rise = 0.165;              ///< height of a step [m]
  double right = -0.7, left = 0.7;  ///< its sides, y [m]
  double thickness = 0.16;          ///< of the slab under the steps [m]

  double length() const { return (steps - 1) * tread; }  ///< from the first riser to the last [m]
  double height() const { return steps * rise; }         ///< [m]
};

/// A walk begins to rise this many treads before a riser, and has risen this many after it.
inline constexpr double kReach = 1.5;

/// The way a body goes over the flight: one smooth rise for each step, spread over 2 kReach treads. It is the mean line
/// of the steps: above them by less than the height of a step, and below by less. `heading` of the flight, `begin` of
/// its first riser along it; `up` is -1 for a flight that leads down.
void add_ramps(Ground& ground, const Flight& flight, double heading, double begin, double up = 1);
/// Treads, risers, sides and the slab below.
void add_steps(MeshBuilder& builder, const Flight& flight, std::uint8_t reflectivity);
/// A round handrail 0.9 m above the mean line of the steps at `y`, on posts if `posts`.
void add_handrail(MeshBuilder& builder, const Flight& flight, double y, bool posts);

}  // namespace aslio::simulator
