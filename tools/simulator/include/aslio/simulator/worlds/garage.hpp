#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Underground garage: pillars on an 8 x 6 m grid, beams and pipes under the ceiling, parked cars, a ramp, views of
/// 60-80 m.
struct GarageParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, GarageParams& params);
};

World build_garage(const GarageParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
