#pragma once
/// From a route to a walk: speeds, sharp turns at the corners, glances, gait.

#include <cstdint>
#include <memory>
#include <vector>

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/realism.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

enum class GaitKind : std::uint8_t { smooth, walking, oscillating, running };

/// The head turns away by `angle` and back while the walk goes on.
struct Glance {
  double at = 0.5;    ///< where on the round, share of its length in (0, 1)
  double angle = 60;  ///< [deg], positive to the left
  double turn = 0.5;  ///< time of each of the two turns [s]
  double hold = 0.3;  ///< time between them [s]
  static void describe(config::Binder& b, Glance& glance);
};

/// `motion:` of a scene file that walks a route.
struct WalkParams {
  GaitKind gait = GaitKind::walking;
  double speed = 1.3;         ///< on straight parts [m/s]
  double corner_speed = 0.8;  ///< through a corner of 90 deg [m/s]
  double corner_radius =
      0.8;  ///< the line is left and met again this far from a corner [m]; at most a third of an edge
  double turn_min = 0.45, turn_max = 0.75;  ///< time for 90 deg, drawn for each corner [s]; sharper corners take longer
  double standstill = 2;                    ///< at the start and at the end [s]
  bool dynamic_start = false;               ///< in full walk at time 0, standstill at the end only
  double height = 1.4;                      ///< of the IMU above the ground [m]
  std::int64_t laps = 1;                    ///< rounds without a stop between them
  std::vector<Glance> glances;
  static void describe(config::Binder& b, WalkParams& params);
};

/// Begins at the first point of the route, looking along its first edge, and ends there in exactly the same pose
/// (position and rotation to 1e-9). Heading follows the edges; each change of direction is one sharp turn whose peak
/// rate is 2.1875 angle / time. `seed` draws turn times, the phases of the gait and what realism adds. Throws
/// ConfigError when the route is too tight for the parameters, naming the edge.
std::unique_ptr<Motion> make_route_walk(const Route& route, const Ground& ground, const WalkParams& params,
                                        std::uint64_t seed, const GaitRealism& realism = {});

}  // namespace aslio::simulator
