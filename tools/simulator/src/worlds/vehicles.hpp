#pragma once
/// Parked vehicles.

#include "aslio/simulator/random.hpp"
#include "worlds/plot.hpp"

namespace aslio::simulator::outdoor {

enum class VehicleKind : std::uint8_t { hatchback, saloon, estate, van };

/// Size and colour of one vehicle.
struct Vehicle {
  VehicleKind kind = VehicleKind::saloon;
  double length = 4.4, width = 1.8, height = 1.45;  ///< [m], mirrors excluded
  std::uint8_t paint = material::kMetal;
};

Vehicle draw_vehicle(RandomStream& random);

/// About the origin of the placement on the ground, front towards +x.
void add_vehicle(MeshBuilder& builder, const Vehicle& vehicle);

/// What it stands on, mirrors included.
Footprint footprint(const Vehicle& vehicle, const Placement& placement);

}  // namespace aslio::simulator::outdoor
