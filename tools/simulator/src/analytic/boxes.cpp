#include "aslio/simulator/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace aslio::simulator {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

/// World vector in the frame of a box.
Vec3 to_box(const Box& box, const Vec3& v) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  return {c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z()};
}

/// 1/d where a zero component would make 0 * inf.
Vec3 inverse(const Vec3& d) {
  return d.unaryExpr([](double x) { return 1 / (std::abs(x) < 1e-12 ? std::copysign(1e-12, x) : x); });
}

/// Range at which a ray enters a box, by the three slabs; the axis of the face by which it enters.
double enter(const Box& box, const Vec3& origin, const Vec3& direction, int& axis) {
  const Vec3 o = to_box(box, origin - box.centre), inv = inverse(to_box(box, direction));
  double from = -kNothing, to = kNothing;
  for (int i = 0; i < 3; ++i) {
    const double a = (-box.half[i] - o[i]) * inv[i], b = (box.half[i] - o[i]) * inv[i];
    if (std::min(a, b) > from) {
      from = std::min(a, b);
      axis = i;
    }
    to = std::min(to, std::max(a, b));
  }
  return from > 0 && from <= to ? from : kNothing;
}

void consider(const Box& box, int index, const Vec3& origin, const Vec3& direction, double limit, Hit& best) {
  int axis = 0;
  const double range = enter(box, origin, direction, axis);
  if (range >= limit) return;
  best = {range, std::abs(to_box(box, direction)[axis]), box.reflectivity, index};
}

}  // namespace

Box box_between(const Vec3& low, const Vec3& high, double reflectivity) {
  return {0.5 * (low + high), 0.5 * (high - low), 0, reflectivity};
}

BoxScene::BoxScene(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const Box& box = boxes_[i];
    if (box.yaw != 0) {
      turned_index_.push_back(static_cast<int>(i));
      continue;
    }
    upright_index_.push_back(static_cast<int>(i));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      upright_[axis].push_back(box.centre[a] - box.half[a]);
      upright_[axis + 3].push_back(box.centre[a] + box.half[a]);
    }
  }
}

Hit BoxScene::cast(const Vec3& origin, const Vec3& direction) const {
  const Vec3 inv = inverse(direction);
  const auto& [lx, ly, lz, hx, hy, hz] = upright_;
  double nearest = kNothing;
  std::size_t found = 0;
  for (std::size_t i = 0; i < upright_index_.size(); ++i) {
    const double ax = (lx[i] - origin.x()) * inv.x(), bx = (hx[i] - origin.x()) * inv.x();
    const double ay = (ly[i] - origin.y()) * inv.y(), by = (hy[i] - origin.y()) * inv.y();
    const double az = (lz[i] - origin.z()) * inv.z(), bz = (hz[i] - origin.z()) * inv.z();
    const double from = std::max(std::max(std::min(ax, bx), std::min(ay, by)), std::min(az, bz));
    const double to = std::min(std::min(std::max(ax, bx), std::max(ay, by)), std::max(az, bz));
    if (from > 0 && from <= to && from < nearest) {
      nearest = from;
      found = i;
    }
  }
  Hit best;
  if (nearest < kNothing) {
    const int index = upright_index_[found];
    consider(boxes_[static_cast<std::size_t>(index)], index, origin, direction, kNothing, best);
  }
  for (const int index : turned_index_) {
    const double limit = best.solid < 0 ? kNothing : best.range;
    consider(boxes_[static_cast<std::size_t>(index)], index, origin, direction, limit, best);
  }
  return best;
}

Hit BoxScene::cast(const Vec3& origin, const Vec3& direction, std::span<const Box> moving) const {
  Hit best = cast(origin, direction);
  int index = static_cast<int>(boxes_.size());
  for (const Box& box : moving) consider(box, index++, origin, direction, best.solid < 0 ? kNothing : best.range, best);
  return best;
}

double BoxScene::clearance(const Vec3& p) const {
  double nearest = kNothing;
  for (const Box& box : boxes_) {
    const Vec3 outside = (to_box(box, p - box.centre).cwiseAbs() - box.half).cwiseMax(0.0);
    nearest = std::min(nearest, outside.norm());
  }
  return nearest;
}

}  // namespace aslio::simulator
