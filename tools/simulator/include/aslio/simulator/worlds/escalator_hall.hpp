#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Hall of a station: a concourse and an upper floor, escalators between them, round columns, glass balustrades, and a
/// barrel vault over all.
struct EscalatorHallParams {
  std::int64_t seed = 1;     ///< of what stands about
  std::int64_t up_edge = 2;  ///< edge of the route, from 1, that the escalators up stand on
  double height = 4.8;       ///< of the upper floor above the concourse [m]; scales
  double margin = 7;         ///< from the route to the walls [m]
  double spring = 9;         ///< where the vault begins, above the concourse [m]
  double columns = 7;        ///< between columns [m]; 0: none
  double clutter = 1;        ///< machines, benches, signs: 0 none, 1 usual
  static void describe(config::Binder& b, EscalatorHallParams& params);
};

/// Throws ConfigError when `up_edge` is too short, or when another edge climbs to the upper floor in another direction.
World build_escalator_hall(const EscalatorHallParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
