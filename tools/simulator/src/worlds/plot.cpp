#include "worlds/plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace aslio::simulator::outdoor {
namespace {

Vec2 turned(const Vec2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double u = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - u * d).norm();
}

/// Whether the segment meets the rectangle of these half sizes round the origin.
bool meets(const Vec2& a, const Vec2& b, const Vec2& half) {
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double d = b[axis] - a[axis];
    if (std::abs(d) < 1e-12) {
      if (std::abs(a[axis]) > half[axis]) return false;
      continue;
    }
    const double u = (-half[axis] - a[axis]) / d, v = (half[axis] - a[axis]) / d;
    from = std::max(from, std::min(u, v));
    to = std::min(to, std::max(u, v));
  }
  return from <= to;
}

/// Whether one of the sides of `a` parts it from `b`.
bool parted(const Footprint& a, const Footprint& b) {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec2& corner : b.corners()) {
    const Vec2 p = a.local(corner);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return low.x() >= a.half.x() || low.y() >= a.half.y() || high.x() <= -a.half.x() || high.y() <= -a.half.y();
}

}  // namespace

std::array<Vec2, 4> Footprint::corners() const {
  const auto at = [&](double x, double y) -> Vec2 { return centre + turned({x * half.x(), y * half.y()}, yaw); };
  return {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
}

Vec2 Footprint::local(const Vec2& p) const { return turned(p - centre, -yaw); }

bool Footprint::overlaps(const Footprint& other) const {
  if ((centre - other.centre).norm() >= radius() + other.radius()) return false;
  return !parted(*this, other) && !parted(other, *this);
}

double Footprint::distance(const Vec2& a, const Vec2& b) const {
  if (meets(local(a), local(b), half)) return 0;
  const auto outside = [&](const Vec2& p) { return (local(p).cwiseAbs() - half).cwiseMax(0.0).norm(); };
  double nearest = std::min(outside(a), outside(b));
  for (const Vec2& corner : corners()) nearest = std::min(nearest, distance_to_segment(corner, a, b));
  return nearest;
}

Footprint footprint(const Placement& placement, const Vec2& low, const Vec2& high) {
  return {placement.origin.head<2>() + turned(0.5 * (low + high), placement.yaw), 0.5 * (high - low), placement.yaw};
}

double distance(const Route& route, const Footprint& area) {
  double nearest = std::numeric_limits<double>::infinity();
  const std::vector<Vec2>& points = route.points();
  for (std::size_t k = 0; k < points.size(); ++k)
    nearest = std::min(nearest, area.distance(points[k], points[(k + 1) % points.size()]));
  return nearest;
}

bool Plot::claim(const Footprint& area, double keep) {
  if (distance(*route_, area) < keep) return false;
  if (std::any_of(taken_.begin(), taken_.end(), [&](const Footprint& other) { return other.overlaps(area); }))
    return false;
  taken_.push_back(area);
  return true;
}

}  // namespace aslio::simulator::outdoor
