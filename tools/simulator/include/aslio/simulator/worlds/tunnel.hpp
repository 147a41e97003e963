#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

enum class TunnelSection : std::uint8_t { circular, horseshoe };

/// Road tunnel with a round vault: straight, a bend in plan, straight; gates close both ends. Few features: niches,
/// cables, lamps, fans. Its axis begins at the origin.
struct TunnelParams {
  std::int64_t seed = 1;  ///< of what hangs on the walls
  TunnelSection section = TunnelSection::circular;
  double radius = 5;               ///< of the vault [m]
  double heading = 0;              ///< of the axis at its begin [deg]
  double before = 60, after = 60;  ///< straight parts of the axis [m]; scale
  double bend = 50;                ///< change of direction [deg], positive to the left
  double bend_radius = 60;         ///< of the axis [m]; scales
  double relief = 1.6;             ///< the road rises and falls by up to this [m]
  double niches = 25;              ///< between niches, on either side in turn [m]; 0: none
  double lamps = 10;               ///< between lamps [m]; 0: none
  double fans = 45;                ///< between pairs of fans under the vault [m]; 0: none
  static void describe(config::Binder& b, TunnelParams& params);
};

/// Throws ConfigError when the route leaves the road.
World build_tunnel(const TunnelParams& params, const Route& route, double scale);

/// Distance of a point to the left of the axis of the tunnel [m]; negative to the right.
double tunnel_offset(const TunnelParams& params, double scale, const Vec2& p);

}  // namespace aslio::simulator
