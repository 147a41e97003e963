#include "aslio/simulator/worlds/approach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/hall.hpp"

namespace aslio::simulator {
namespace {

namespace m = material;

constexpr double kBehind = 10;      ///< the way begins this far behind the start [m]
constexpr double kPiece = 0.5;      ///< of its surfaces, which follow the ground [m]
constexpr double kSameLine = 1e-3;  ///< [m]

/// The way from the start to the garage, in a frame with x along it and its origin at the start.
struct Way {
  double length = 60, half = 1.5, height = 2.6, bare = 25;
  Ground ground;  ///< in the same frame
};

/// The route in the frame of the way.
Route in_way(const Route& route, const Way& way) {
  const std::vector<Vec2>& points = route.points();
  const Vec2& start = points.front();
  const Vec2 along = route.at(0).direction, across(-along.y(), along.x());
  std::vector<Vec2> local;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec2 p(along.dot(points[k] - start), across.dot(points[k] - start));
    if (p.x() < way.length + 1 && std::abs(p.y()) > kSameLine)
      throw ConfigError(
          fmt::format("route: point {} at ({:.2f}, {:.2f}) [m] is {:.2f} m beside the way to the garage, which is "
                      "{:.1f} m long. Move it onto the first edge or beyond the way, or make world.length smaller",
                      k + 1, points[k].x(), points[k].y(), std::abs(p.y()), way.length));
    local.push_back(p);
  }
  return Route(std::move(local));
}

/// Floor, walls and ceiling without a mark, down to the garage.
void add_shell(MeshBuilder& builder, const Way& way) {
  const int pieces = static_cast<int>(std::ceil((way.length + kBehind) / kPiece));
  const double w = way.half;
  for (int k = 0; k < pieces; ++k) {
    const double x0 = -kBehind + (way.length + kBehind) * k / pieces;
    const double x1 = -kBehind + (way.length + kBehind) * (k + 1) / pieces;
    const double z0 = way.ground.height(x0, 0), z1 = way.ground.height(x1, 0), h = way.height;
    builder.quad({x0, -w, z0}, {x1, -w, z1}, {x1, w, z1}, {x0, w, z0}, m::kConcrete);
    builder.quad({x0, -w, z0 + h}, {x1, -w, z1 + h}, {x1, w, z1 + h}, {x0, w, z0 + h}, m::kConcrete);
    for (const double y : {-w, w})
      builder.quad({x0, y, z0}, {x1, y, z1}, {x1, y, z1 + h}, {x0, y, z0 + h}, m::kPlaster);
  }
  // Roller door behind the start: slats, one in two a bit farther out.
  constexpr int kSlats = 16;
  for (int k = 0; k < kSlats; ++k) {
    const double z = way.height * k / kSlats, x = -kBehind + (k % 2 == 0 ? 0.03 : 0.06);
    builder.box({-kBehind, -w, z}, {x, w, z + way.height / kSlats}, m::kMetal);
  }
}

/// Beyond the bare part: pilasters, doors, pipes, lamps.
void add_marks(MeshBuilder& builder, const Way& way, std::uint64_t seed) {
  for (const double side : {-1.0, 1.0}) {
    RandomStream random(seed, purpose::kLayout, side > 0 ? 1000 : 1001);
    for (double x = way.bare + random.uniform(1, 3); x < way.length - 1.5; x += random.uniform(3.5, 7)) {
      const double kind = random.uniform(), z = way.ground.height(x, 0);
      const double inner = side * (way.half - 0.15), wall = side * way.half;
      const auto on_wall = [&](double from, double to, double depth, double low, double high,
                               std::uint8_t reflectivity) {
        const double y = wall - side * depth;
        builder.box({x + from, std::min(y, wall), z + low}, {x + to, std::max(y, wall), z + high}, reflectivity);
      };
      if (kind < 0.5) {
        on_wall(-0.2, 0.2, 0.15, -0.1, way.height + 0.1, m::kConcrete);
      } else if (kind < 0.75) {
        on_wall(-0.55, 0.55, 0.06, -0.1, 2.12, m::kMetal);
        on_wall(-0.48, 0.48, 0.08, -0.1, 2.05, m::kWhitePaint);
      } else {
        builder.frustum({x, inner + side * 0.07, z - 0.1}, 0.06, 0.06, way.height + 0.2, 10, m::kMetal);
      }
    }
  }
  for (double x = way.bare + 2; x < way.length - 2; x += 5) {
    const double z = way.ground.height(x, 0) + way.height;
    builder.box({x, -0.06, z - 0.14}, {x + 1.2, 0.06, z + 0.05}, m::kWhitePaint);
  }
}

}  // namespace

void ApproachParams::describe(config::Binder& b, ApproachParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("length", params.length, "m", {.min = 5.0, .max = 500.0}, "of the way to the garage; scales with the route");
  b.real("width", params.width, "m", {.min = 1.8, .max = 10.0}, "of the way");
  b.real("height", params.height, "m", {.min = 2.3, .max = 2.8}, "of the ceiling over the way");
  b.real("bare", params.bare, "m", {.min = 0.0, .max = 500.0},
         "first part of the way without pilasters and doors; scales with the route");
  b.real("drop", params.drop, "m", {.min = 0.0, .max = 20.0}, "from the start down to the garage; scales");
  b.real("margin", params.margin, "m", {.min = 4.0, .max = 100.0}, "from the route to the walls of the garage");
  b.real("parked", params.parked, "1", {.min = 0.0, .max = 1.0}, "share of the bays with a vehicle in them");
  b.require(params.bare <= params.length, "bare", "must not be above length");
}

World build_approach(const ApproachParams& params, const Route& route, double scale) {
  const auto seed = static_cast<std::uint64_t>(params.seed);
  Way way{scale * params.length, 0.5 * params.width, params.height, scale * params.bare, {}};
  way.ground.ramps.push_back({0, 0, way.length, -scale * params.drop});
  const Route local = in_way(route, way);

  const Vec2 start = route.points().front(), along = route.at(0).direction;
  const double heading = std::atan2(along.y(), along.x());
  MeshBuilder builder;
  {
    const auto placed = builder.place({Vec3(start.x(), start.y(), 0), heading});
    add_shell(builder, way);
    add_marks(builder, way, seed);
    outdoor::Hall hall;
    hall.area = indoor::Rect{local.low(), local.high()}.grown(params.margin);
    hall.area.low.x() = way.length;
    hall.parked = params.parked;
    hall.gates.push_back({-way.half, way.half, way.height});
    const auto below = builder.place({Vec3(0, 0, -scale * params.drop), 0});
    outdoor::build_hall(builder, hall, local, seed);
  }
  Ground ground;
  ground.ramps.push_back({heading, along.dot(start), way.length, -scale * params.drop});
  return {builder.take(), ground};
}

}  // namespace aslio::simulator
