#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Rooms joined by narrow doorways and a stairwell, for sensors that see all round.
struct DoorwayParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, DoorwayParams& params);
};

World build_doorway(const DoorwayParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
