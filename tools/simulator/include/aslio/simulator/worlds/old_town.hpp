#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Old town on a slope: narrow alleys, houses at any angle, many with curved fronts, arcades on round columns, round
/// towers at the corners, vaulted passages, and outdoor steps between two terraces.
struct OldTownParams {
  std::int64_t seed = 1;      ///< of the layout
  double alley = 3.6;         ///< least width between the fronts [m]; the route is its middle
  double relief = 1.2;        ///< the ground rises and falls by up to this [m]
  std::int64_t steps = 8;     ///< from the lower terrace to the upper one; 0: there is one terrace
  double curved = 0.5;        ///< share of the houses with a curved front
  double arcades = 0.15;      ///< share of the houses that stand on columns
  std::int64_t passages = 3;  ///< vaults over the alley, where there is room
  double skew = 5;            ///< fronts are turned against the alley by up to this [deg]
  static void describe(config::Binder& b, OldTownParams& params);
};

/// Edges of the route may have any direction.
World build_old_town(const OldTownParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
