#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Approach to a garage, 60 m x 3 m with bare smooth walls down a ramp, no pillars or doors in its first 25 m, then the
/// garage: degenerate along its axis.
struct ApproachParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, ApproachParams& params);
};

World build_approach(const ApproachParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
