/// The tunnel as it is shipped, whole and shortened, in both cross-sections.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "simulator/worlds/world_checks.hpp"

using namespace aslio;
using namespace aslio::simulator;
using namespace aslio::simulator::testing;

TEST_CASE("a tunnel leaves the route free, stands on its ground and has no holes", "[worlds]") {
  const TunnelSection section = GENERATE(TunnelSection::circular, TunnelSection::horseshoe);
  const double scale = GENERATE(0.2, 0.6, 1.0);
  CAPTURE(static_cast<int>(section), scale);
  const auto [scene, route] = shipped("tunnel", scale);
  TunnelParams params = scene.world.tunnel;
  params.section = section;
  const World world = build_tunnel(params, route, scale);
  CHECK(worst_clearance(world, route) >= 1 - 1e-6);
  const Caster caster(world.mesh);
  CHECK(worst_ground(world, caster, route) < 0.01);
  CHECK(share_of_hits(world, caster, route) > 0.999);
  CHECK(world.mesh.triangles.size() < 600'000);
}

TEST_CASE("the vault of a bare tunnel is a circle to 2 mm about its axis, in the bend as well", "[worlds]") {
  const auto [scene, route] = shipped("tunnel", 1);
  TunnelParams params = scene.world.tunnel;
  params.relief = params.niches = params.lamps = params.fans = 0;
  const Caster caster(build_tunnel(params, route, 1).mesh);
  double worst = 0;
  for (double s = 3; s < 0.45 * route.length(); s += 0.37) {
    const Route::Place place = route.at(s);
    const Vec2 left(-place.direction.y(), place.direction.x());
    for (double angle = 0.7; angle < 2.45; angle += 0.1) {  // above the cables
      const Vec3 from(place.at.x(), place.at.y(), 1.5);
      const Vec3 d(std::cos(angle) * left.x(), std::cos(angle) * left.y(), std::sin(angle));
      const Vec3 hit = from + caster.cast(from, d, 50).range * d;
      const double across = tunnel_offset(params, 1, hit.head<2>());
      worst = std::max(worst, std::abs(std::hypot(across, hit.z() - 1.8) - params.radius));
    }
  }
  CHECK(worst < 0.002 + 0.001);  // and the search for the nearest point of the axis
}

TEST_CASE("the seed of a tunnel gives its bits, and niches open its walls", "[worlds]") {
  const auto [scene, route] = shipped("tunnel", 1);
  TunnelParams params = scene.world.tunnel;
  const World first = build_tunnel(params, route, 1);
  CHECK(same_bits(first.mesh, build_tunnel(params, route, 1).mesh));
  // Farther from the axis than its radius: only in niches.
  const auto beyond = [&](const World& world) {
    const Caster caster(world.mesh);
    int rays = 0;
    for (double s = 0; s < route.length(); s += 0.2) {
      const Route::Place place = route.at(s);
      for (const double side : {-1.0, 1.0}) {
        const Vec3 d(-side * place.direction.y(), side * place.direction.x(), 0);
        const Vec3 eye(place.at.x(), place.at.y(), world.ground.height(place.at.x(), place.at.y()) + 1.4);
        const Vec3 hit = eye + caster.cast(eye, d, 50).range * d;
        rays += std::abs(tunnel_offset(params, 1, hit.head<2>())) > params.radius + 0.3 ? 1 : 0;
      }
    }
    return rays;
  };
  CHECK(beyond(first) > 20);
  params.niches = 0;
  CHECK(beyond(build_tunnel(params, route, 1)) == 0);
  params.seed += 1;
  CHECK_FALSE(same_bits(first.mesh, build_tunnel(params, route, 1).mesh));
}

TEST_CASE("a tunnel names the place where a route leaves its road", "[worlds]") {
  const auto [scene, route] = shipped("tunnel", 1);
  TunnelParams params = scene.world.tunnel;
  params.bend = -params.bend;
  using Catch::Matchers::Contains;
  CHECK_THROWS_AS(build_tunnel(params, route, 1), ConfigError);
  CHECK_THROWS_WITH(build_tunnel(params, route, 1), Contains("m of the round") && Contains("world.radius"));
  CHECK_THROWS_WITH(load_scene(ASLIO_SOURCE_DIR "/configs/scenes/tunnel.yaml", {"world.lamps=2"}),
                    Contains("world.lamps") && Contains("0 or at least 4"));
}
