#pragma once
/// The sides from which planes in voxels are seen (docs/equations.md MAP-4), and what a query meets of them. For nodes
/// with the members count, stamp, planar, sided, view, normal, mean, along, longest and shortest, and for roots with a
/// node: the points of a coarsest voxel are in one or two of them.

#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "aslio/stages/map.hpp"
#include "maps/plane_shape.hpp"

namespace aslio::plugins {

/// A direction, or a sum of some, in steps of 1 / kViewSteps.
using ViewSteps = std::array<std::int16_t, 3>;
inline constexpr float kViewSteps = 127;
/// Directions whose sum 16 bits hold.
inline constexpr std::uint32_t kMaxViews = 256;
/// Distance from a plane within which a point seen along it is one of its own, in thicknesses.
inline constexpr float kOwn = 2;

inline Eigen::Vector3f sum_of(const ViewSteps& view) { return Eigen::Vector3f(view[0], view[1], view[2]); }

/// Of a direction of unit length, or zero.
inline ViewSteps steps_of(const Eigen::Vector3f& direction) {
  ViewSteps steps{};
  for (int axis = 0; axis < 3; ++axis)
    steps[static_cast<std::size_t>(axis)] = static_cast<std::int16_t>(kViewSteps * direction[axis]);
  return steps;
}

/// Counts a point, and how it is seen as long as its sum has room.
template <class Node>
inline void count_point(Node& node, const ViewSteps& view) {
  if (++node.count > kMaxViews) return;
  for (std::size_t axis = 0; axis < 3; ++axis)
    node.view[axis] = static_cast<std::int16_t>(node.view[axis] + view[axis]);
}

/// The node is as its points are, whose mean is `mean`; a plane from update `stamp` on, if it was none.
template <class Node>
inline void set_plane(Node& node, const PlaneShape& shape, const Vec3& mean, std::uint32_t stamp) {
  if (shape.planar && !node.planar) node.stamp = stamp;
  node.planar = shape.planar;
  node.mean = mean.cast<float>();
  node.normal = shape.normal.cast<float>();
  const float away = sum_of(node.view).dot(node.normal);
  node.sided = away != 0;
  if (away > 0) node.normal = -node.normal;
  node.along = shape.along.cast<float>();
  node.longest = static_cast<float>(shape.variance[2]);
  node.shortest = static_cast<float>(shape.variance[1]);
}

/// Whether a point at p, seen in the direction `view` (unit, or zero), belongs to the first part of its voxel: to
/// `plane`, what that has there, or to its points `all`, where it has none.
template <class Node>
inline bool is_of_first(const Node* plane, const Node& all, const Eigen::Vector3f& p, const Eigen::Vector3f& view,
                        double thickness) {
  if (plane == nullptr) return view.dot(sum_of(all.view)) >= 0;
  const float away = plane->sided ? view.dot(plane->normal) : 0;
  const float distance = std::abs((p - plane->mean).dot(plane->normal));
  return away <= 0 || (away <= kGrazing && distance <= kOwn * static_cast<float>(thickness));
}

/// Of the planes in both parts, plane_at(part), one that faces who looks in the direction `view`; else one that is seen
/// along it. `second`: nullptr if there is one part.
template <class Root, class PlaneAt>
inline auto facing(const Root& first, const Root* second, const Eigen::Vector3f& view, PlaneAt plane_at)
    -> decltype(plane_at(first)) {
  decltype(plane_at(first)) along = nullptr;
  for (const Root* part : {&first, second}) {
    if (part == nullptr) break;
    const auto plane = plane_at(*part);
    if (plane == nullptr) continue;
    const float away = plane->sided ? view.dot(plane->normal) : 0;
    if (away <= 0) return plane;
    if (away <= kGrazing && along == nullptr) along = plane;
  }
  return along;
}

/// The plane of either part; the first, if both have one.
template <class Root, class PlaneAt>
inline auto either(const Root& first, const Root* second, PlaneAt plane_at) -> decltype(plane_at(first)) {
  const auto plane = plane_at(first);
  return plane == nullptr && second != nullptr ? plane_at(*second) : plane;
}

/// What `query` meets of the planes in both parts: with `faces` one that faces where it is asked from, else that of
/// either.
template <class Root, class PlaneAt>
inline auto met(const Vec3& query, const MapQuery& how, bool faces, const Root& first, const Root* second,
                PlaneAt plane_at) {
  return faces && how.viewpoint ? facing(first, second, (query - *how.viewpoint).cast<float>().normalized(), plane_at)
                                : either(first, second, plane_at);
}

/// What a query at p meets of a plane. `corner`: of its voxel, in W.
template <class Node>
inline Surface surface_of(const Node& plane, const Vec3& corner, const Eigen::Vector3f& p, double doubt) {
  Surface found;
  found.normal = plane.normal.template cast<double>().normalized();
  found.anchor = corner + plane.mean.template cast<double>();
  found.quality =
      plane_quality(plane.count, doubt, p - plane.mean, plane.normal, plane.along, plane.longest, plane.shortest);
  found.valid = true;
  found.owner = &plane;
  return found;
}

}  // namespace aslio::plugins
