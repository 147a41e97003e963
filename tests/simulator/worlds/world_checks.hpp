#pragma once
/// What every built world must hold along its route.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/route.hpp"
#include "aslio/simulator/scene.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::simulator::testing {

struct ShippedRoute {
  Scene scene;
  Route route;
};

inline ShippedRoute shipped(const std::string& name, double scale) {
  Scene scene = load_scene(ASLIO_SOURCE_DIR "/configs/scenes/" + name + ".yaml").scene;
  std::vector<Vec2> points;
  for (const RoutePoint& p : scene.route) points.emplace_back(scale * p.x, scale * p.y);
  return {std::move(scene), Route(std::move(points))};
}

inline bool same_bits(const Mesh& a, const Mesh& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  return same(a.vertices, b.vertices) && same(a.triangles, b.triangles) && same(a.reflectivity, b.reflectivity);
}

/// The part of a polygon above (sign 1) or below (sign -1) a height.
inline std::vector<Vec3> cut(const std::vector<Vec3>& polygon, double height, double sign) {
  std::vector<Vec3> part;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double da = sign * (a.z() - height), db = sign * (b.z() - height);
    if (da >= 0) part.push_back(a);
    if ((da >= 0) != (db >= 0)) part.push_back(a + (b - a) * (da / (da - db)));
  }
  return part;
}

inline double distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double along = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - along * d).norm();
}

inline double cross(const Vec2& u, const Vec2& v) { return u.x() * v.y() - u.y() * v.x(); }

/// In the plan, between a segment and a convex polygon.
inline double distance(const Vec2& a, const Vec2& b, const std::vector<Vec3>& polygon) {
  double least = std::numeric_limits<double>::infinity();
  bool left = true, right = true;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec2 p = polygon[k].head<2>(), q = polygon[(k + 1) % polygon.size()].head<2>();
    least = std::min({least, distance(p, a, b), distance(q, a, b), distance(a, p, q), distance(b, p, q)});
    const double pa = cross(q - p, a - p), pb = cross(q - p, b - p);
    if (pa * pb < 0 && cross(b - a, p - a) * cross(b - a, q - a) < 0) return 0;
    left = left && pa > 0;
    right = right && pa < 0;
  }
  return left || right ? 0 : least;
}

/// How near, in the plan, the surfaces between 0.2 and 2.2 m above the ground come to the route, as a share of what
/// must be kept: 0.6 m, or 0.35 m on the parts of the route within `door_reach` of a door.
inline double worst_clearance(const World& world, const Route& route, const std::vector<Vec2>& doors = {},
                              double door_reach = 0.5) {
  struct Part {
    Vec2 a, b;
    double keep;
  };
  std::vector<Part> parts;
  const auto pieces = static_cast<int>(std::ceil(route.length() / 0.1));
  for (int k = 0; k < pieces; ++k) {
    const Vec2 a = route.at(route.length() * k / pieces).at, b = route.at(route.length() * (k + 1) / pieces).at;
    const bool at_door =
        std::any_of(doors.begin(), doors.end(), [&](const Vec2& d) { return (0.5 * (a + b) - d).norm() < door_reach; });
    parts.push_back({a, b, at_door ? 0.35 : 0.6});
  }
  double worst = std::numeric_limits<double>::infinity();
  for (const Mesh::Triangle& t : world.mesh.triangles) {
    std::vector<Vec3> polygon;
    for (const std::uint32_t v : {t.a, t.b, t.c}) {
      const Vec3 p = world.mesh.vertices[v].cast<double>();
      polygon.push_back(p - Vec3(0, 0, world.ground.height(p.x(), p.y())));
    }
    polygon = cut(cut(polygon, 0.2, 1), 2.2, -1);
    if (polygon.empty()) continue;
    Vec2 low = polygon[0].head<2>(), high = low;
    for (const Vec3& p : polygon) {
      low = low.cwiseMin(p.head<2>());
      high = high.cwiseMax(p.head<2>());
    }
    if (route.distance(0.5 * (low + high)) > 0.5 * (high - low).norm() + 1) continue;
    for (const Part& part : parts) {
      if ((0.5 * (part.a + part.b) - 0.5 * (low + high)).norm() > 0.5 * (high - low).norm() + 1) continue;
      worst = std::min(worst, distance(part.a, part.b, polygon) / part.keep);
    }
  }
  return worst;
}

/// Largest difference between the closed form of the ground and the mesh along the route [m].
inline double worst_ground(const World& world, const Caster& caster, const Route& route) {
  double worst = 0;
  for (double s = 0; s < route.length(); s += 0.05) {
    const Vec2 p = route.at(s).at;
    const double z = world.ground.height(p.x(), p.y());
    const SurfaceHit hit = caster.cast(Vec3(p.x(), p.y(), z + 0.2), -Vec3::UnitZ(), 10);
    worst = std::max(worst, std::abs(hit.range - 0.2));
  }
  return worst;
}

/// Unit vectors all round, evenly spread (Fibonacci's spiral).
inline std::vector<Vec3> directions_all_round(int count) {
  std::vector<Vec3> directions;
  for (int k = 0; k < count; ++k) {
    const double z = 1 - (2.0 * k + 1) / count, angle = k * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

/// Share of the rays from a walker's head that hit something within 100 m.
inline double share_of_hits(const World& world, const Caster& caster, const Route& route) {
  const std::vector<Vec3> directions = directions_all_round(2000);
  std::vector<SurfaceHit> hits(directions.size());
  std::size_t rays = 0, found = 0;
  for (double s = 0; s < route.length(); s += 0.5) {
    const Vec2 p = route.at(s).at;
    caster.cast(Vec3(p.x(), p.y(), world.ground.height(p.x(), p.y()) + 1.4), directions, 100, hits);
    rays += hits.size();
    found += static_cast<std::size_t>(
        std::count_if(hits.begin(), hits.end(), [](const SurfaceHit& h) { return std::isfinite(h.range); }));
  }
  return static_cast<double>(found) / static_cast<double>(rays);
}

}  // namespace aslio::simulator::testing
