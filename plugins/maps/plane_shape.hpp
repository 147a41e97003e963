#pragma once
/// What the maps of planes have in common: when points are a plane, and how well one is known (docs/equations.md MAP-1,
/// MAP-2).

#include <algorithm>
#include <cstdint>
#include <span>

#include "aslio/core/lie.hpp"
#include "aslio/stages/map.hpp"

namespace aslio::plugins {

/// Of the grid against the origin, in voxels: walls stand at round numbers, and a wall in the face between two voxels
/// has half of its points in each.
inline const Vec3 kGridOffset{0.137, 0.223, 0.311};
/// Sine of the angle between view and plane below which the side it is seen from is not certain: 6 deg. eq. MAP-4.
inline constexpr float kGrazing = 0.1F;
/// Growth of the count of points that is worth a new fit.
inline constexpr double kRefit = 1.1;
/// Error of a variance summed up in floats, in units of the squared edge of a voxel: what is below it is rounding.
inline constexpr double kRounding = 1e-6;

/// Least variance in a plane over that across it, where noise is so many times what the parameters say. eq. NOI-2.
double least_aspect(double noise_scale);

struct PlaneLimits {
  double thickness;  ///< maximum standard deviation across [m]
  double aspect;     ///< least_aspect()
  double rounding;   ///< variance below which is rounding [m^2]
};

/// The plane through the mean of some points.
struct PlaneShape {
  Vec3 normal, along;  ///< unit; `along` of the largest variance
  Vec3 variance;       ///< ascending [m^2]; the first is that across
  bool planar;
};
/// eq. MAP-1, but for the count of points.
PlaneShape plane_shape(const Mat3& covariance, const PlaneLimits& limits);

/// How much a match at the offset d [m] from the mean counts of a plane of `count` points. eq. MAP-2.
inline double plane_quality(std::uint32_t count, double doubt, const Eigen::Vector3f& d, const Eigen::Vector3f& normal,
                            const Eigen::Vector3f& along_axis, float longest, float shortest) {
  const float across = d.dot(normal), along = d.dot(along_axis);
  const float rest = std::max(0.0F, d.squaredNorm() - across * across - along * along);
  const double leverage = 1.0 + static_cast<double>(along * along / longest + rest / shortest);
  return count / (count + doubt * leverage);
}

/// A map of surfaces keeps no points that could be neighbours.
inline void find_no_neighbours(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) {
  out.resize(queries.size(), std::clamp(query.k, 1, Neighbours::kMax));
  std::fill(out.count.begin(), out.count.end(), std::uint8_t{0});
}

}  // namespace aslio::plugins
