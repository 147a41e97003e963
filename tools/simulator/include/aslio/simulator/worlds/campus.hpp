#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Campus: streets along the route with kerbs, facades with windows, trees, parked cars, street furniture, relief.
struct CampusParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, CampusParams& params);
};

World build_campus(const CampusParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
