#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "aslio/core/errors.hpp"
#include "worlds/floor_plan.hpp"

namespace aslio::simulator::indoor {
namespace {

constexpr double kSameLine = 1e-3;  // [m]

constexpr double kSill = 0.9;  // [m]
double head_of_windows(double ceiling) { return std::min(2.2, ceiling - 0.2); }

Rect around(const Vec2& p, const Vec2& q) { return {p.cwiseMin(q), p.cwiseMax(q)}; }

Rect placed(const Placement& placement, const Vec2& low, const Vec2& high) {
  const double c = std::cos(placement.yaw), s = std::sin(placement.yaw);
  const auto at = [&](const Vec2& p) -> Vec2 {
    return placement.origin.head<2>() + Vec2(c * p.x() - s * p.y(), s * p.x() + c * p.y());
  };
  return around(at(low), at(high));
}

}  // namespace

Vec2 Run::point(double along, double across) const {
  return axis == 0 ? Vec2(along, at + across) : Vec2(at + across, along);
}

Rect Run::rect(double begin, double end, double right, double left) const {
  return around(point(begin, right), point(end, left));
}

std::vector<Run> runs_of(const Route& route, const char* world) {
  const std::vector<Vec2>& points = route.points();
  std::vector<Run> runs;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec2 &p = points[k], &q = points[(k + 1) % points.size()];
    const Vec2 d = (q - p).cwiseAbs();
    if (d.minCoeff() > kSameLine) {
      throw ConfigError(
          fmt::format("route: edge {} from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) [m] is not parallel to the x or y "
                      "axis. A world of type '{}' needs this: put a corner between them",
                      k, p.x(), p.y(), q.x(), q.y(), world));
    }
    const int axis = d.x() >= d.y() ? 0 : 1;
    runs.push_back({axis, p[1 - axis], std::min(p[axis], q[axis]), std::max(p[axis], q[axis])});
  }
  const auto order = [](const Run& r) { return std::make_tuple(r.axis, r.at, r.lo, r.hi); };
  std::sort(runs.begin(), runs.end(), [&](const Run& a, const Run& b) { return order(a) < order(b); });
  std::vector<Run> merged;
  for (const Run& run : runs) {
    const auto same = std::find_if(merged.begin(), merged.end(), [&](const Run& m) {
      return m.axis == run.axis && std::abs(m.at - run.at) <= kSameLine && run.lo <= m.hi + kSameLine &&
             m.lo <= run.hi + kSameLine;
    });
    if (same == merged.end()) {
      merged.push_back(run);
    } else {
      same->lo = std::min(same->lo, run.lo);
      same->hi = std::max(same->hi, run.hi);
    }
  }
  return merged;
}

std::vector<Rect> clear_zones(const Route& route, double by) {
  const std::vector<Vec2>& points = route.points();
  std::vector<Rect> zones;
  for (std::size_t k = 0; k < points.size(); ++k) {
    zones.push_back(around(points[k], points[(k + 1) % points.size()]).grown(by));
    zones.push_back(Rect{points[k], points[k]}.grown(by + 0.3));
  }
  return zones;
}

bool Site::claim(const Rect& area, double height) {
  if (!grid_->free(area, 0, height)) return false;
  if (std::any_of(taken_.begin(), taken_.end(), [&](const Rect& r) { return r.overlaps(area); })) return false;
  taken_.push_back(area);
  return true;
}

bool Site::claim(const Placement& placement, const Vec2& low, const Vec2& high, double height) {
  return claim(placed(placement, low, high), height);
}

Placement at_wall(const Vec2& at, const Vec2& normal) {
  return {Vec3(at.x(), at.y(), 0), std::atan2(-normal.x(), normal.y())};
}

Placement at_wall(const WallFace& face) {
  const Vec2 along(face.normal.y(), -face.normal.x());
  return at_wall(along.dot(face.b - face.a) > 0 ? face.a : face.b, face.normal);
}

Rect Door::area() const {
  const Vec2 across(-normal.y(), normal.x());
  const double reach = open ? depth : 0.1;
  return around(at - 0.5 * width * across, at + 0.5 * width * across - reach * normal);
}

void add_door(FloorPlan& plan, const Door& door) { plan.add({door.area(), 0, kDoorHead}); }

void build_door(MeshBuilder& builder, Site& site, const Door& door) {
  const double w = 0.5 * door.width, inside = door.open ? door.depth : 0.1;
  const Placement frame_of_door = at_wall(door.at, door.normal);
  for (const double x : {-w - 0.06, w + 0.01}) {
    // On a short route the wall of one room may lie in another: no frame stands in the open.
    if (site.grid().free(placed(frame_of_door, {x, 0.01 - inside}, {x + 0.05, -0.01}), 0, 1)) return;
  }
  const auto at_door = builder.place(frame_of_door);
  const auto frame = [&](double y0, double y1) {
    builder.box({-w - 0.07, y0, 0}, {-w + 0.01, y1, kDoorHead + 0.07}, material::kWood);
    builder.box({w - 0.01, y0, 0}, {w + 0.07, y1, kDoorHead + 0.07}, material::kWood);
    builder.box({-w + 0.01, y0, kDoorHead - 0.01}, {w - 0.01, y1, kDoorHead + 0.07}, material::kWood);
  };
  frame(-0.02, 0.02);
  const double side = door.hinge_left ? 1 : -1;
  if (!door.open) {
    builder.box({side * 0.3 - 0.07, -inside, 1.0}, {side * 0.3 + 0.07, -inside + 0.06, 1.03}, material::kMetal);
    builder.box({-w + 0.08, -inside, 0.02}, {w - 0.08, -inside + 0.012, 0.22}, material::kMetal);
    return;
  }
  frame(-inside - 0.02, -inside + 0.02);
  // The leaf lies within this square on the far side, turned about its hinge.
  const Vec2 hinge(side * w, -inside - 0.02);
  const double reach = door.width - 0.02;
  const double tip = hinge.x() - side * reach * std::cos(door.swing);
  const double thick = 0.05;
  const Vec2 low(std::min(hinge.x(), tip) - (side > 0 ? 0 : thick), hinge.y() - reach * std::sin(door.swing) - thick);
  const Vec2 high(std::max(hinge.x(), tip) + (side > 0 ? thick : 0), hinge.y());
  if (!site.claim(frame_of_door, low, high)) return;
  const auto leaf =
      builder.place({Vec3(hinge.x(), hinge.y(), 0), side * door.swing + (side > 0 ? std::numbers::pi : 0)});
  // Its thickness lies away from the passage.
  const double y0 = side > 0 ? 0 : -thick, y1 = y0 + thick;
  builder.box({0, y0, 0.01}, {reach, y1, kDoorHead - 0.02}, material::kWood);
  builder.box({reach - 0.15, y0 - 0.04, 1.0}, {reach - 0.03, y1 + 0.04, 1.03}, material::kMetal);
}

std::vector<Rect> add_windows(FloorPlan& plan, const std::vector<Rect>& rooms, double ceiling) {
  std::vector<Rect> panes;
  for (const Rect& room : rooms) {
    for (const double side : {-1.0, 1.0}) {
      for (const int axis : {0, 1}) {
        const double at = side > 0 ? room.high[1 - axis] : room.low[1 - axis];
        const Run wall{axis, at, room.low[axis] + 0.5, room.high[axis] - 0.5};
        const double length = wall.hi - wall.lo;
        if (length < 1.2) continue;
        const auto niche = [&](double begin, double end, double d0, double d1) {
          return wall.rect(begin, end, std::min(side * d0, side * d1), std::max(side * d0, side * d1));
        };
        if (plan.meets(niche(wall.lo, wall.hi, 0.01, 0.5))) continue;
        const int count = static_cast<int>(std::ceil(length / 2.5));
        for (int k = 0; k < count; ++k) {
          const double begin = wall.lo + length * k / count + 0.1, end = wall.lo + length * (k + 1) / count - 0.1;
          plan.add({niche(begin, end, 0, 0.2), kSill, head_of_windows(ceiling)});
          panes.push_back(niche(begin, end, 0.14, 0.16));
        }
      }
    }
  }
  return panes;
}

void build_windows(MeshBuilder& builder, const std::vector<Rect>& panes, double ceiling) {
  for (const Rect& pane : panes)
    builder.box({pane.low.x(), pane.low.y(), kSill}, {pane.high.x(), pane.high.y(), head_of_windows(ceiling)},
                material::kGlass);
}

}  // namespace aslio::simulator::indoor
