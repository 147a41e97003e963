#include "aslio/simulator/worlds/garage.hpp"

#include <algorithm>

#include "aslio/config/binder.hpp"
#include "worlds/hall.hpp"

namespace aslio::simulator {

void GarageParams::describe(config::Binder& b, GarageParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("margin", params.margin, "m", {.min = 4.0, .max = 100.0}, "from the route to the walls of the storey");
  b.real("height", params.height, "m", {.min = 2.8, .max = 6.0}, "of the ceiling; beams end 0.42 m below it");
  b.real("pillar_x", params.pillar_x, "m", {.min = 3.0, .max = 30.0}, "between pillars along x");
  b.real("pillar_y", params.pillar_y, "m", {.min = 5.5, .max = 30.0}, "between pillars along y");
  b.real("parked", params.parked, "1", {.min = 0.0, .max = 1.0}, "share of the bays with a vehicle in them");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 3.0},
         "things on walls, ceiling and floor: 0 none, 1 usual");
}

World build_garage(const GarageParams& params, const Route& route, double /*scale*/) {
  outdoor::Hall hall;
  hall.area = indoor::Rect{route.low(), route.high()}.grown(params.margin);
  hall.height = params.height;
  hall.grid_x = params.pillar_x;
  hall.grid_y = params.pillar_y;
  hall.parked = params.parked;
  hall.clutter = params.clutter;
  // The gate lies in line with the first aisle.
  const double aisle = route.points().front().y();
  const outdoor::Hall::Gate gate{aisle - 2.2, aisle + 2.2, 2.45};
  hall.gates.push_back(gate);
  MeshBuilder builder;
  outdoor::build_hall(builder, hall, route, static_cast<std::uint64_t>(params.seed));
  outdoor::build_ramp(builder, hall, gate, 20, 3);
  return {builder.take(), Ground{}};
}

}  // namespace aslio::simulator
