#pragma once
/// A plane that grows by points, and the search for one among points of which many lie on none.

#include <array>
#include <cstdint>
#include <span>

#include "aslio/core/lie.hpp"
#include "aslio/toolkit/block_pool.hpp"
#include "maps/plane_shape.hpp"

namespace aslio::plugins {

/// Sums of points and the plane through them. Coordinates are relative to the corner of a voxel [m].
class SampledPlane {
 public:
  void clear() { *this = {}; }
  /// `toward`: the direction it is seen in, of any length; zero if not known.
  void add(const Eigen::Vector3f& p, const Eigen::Vector3f& toward);
  /// Fits the plane to the points so far; false if they are none. `thickness`, `aspect`: of PlaneLimits; `edge`: of the
  /// coarsest voxels [m], which bounds the rounding of the sums.
  bool fit(double thickness, double aspect, double edge);

  std::uint32_t count() const { return count_; }
  /// Count from which another fit is worth its time.
  std::uint32_t next_fit() const { return next_fit_; }
  const Eigen::Vector3f& normal() const { return normal_; }
  const Eigen::Vector3f& mean() const { return mean_; }
  float distance(const Eigen::Vector3f& p) const { return (p - mean_).dot(normal_); }
  /// Positive: seen from behind, by the cosine of that. 0 where either side is not known.
  float from_behind(const Eigen::Vector3f& direction) const { return sided_ ? direction.dot(normal_) : 0; }
  bool sided() const { return sided_; }
  /// Squared distance from the mean within the plane, in variances of its points: 3 at the edge of an even spread along
  /// one axis.
  float reach(const Eigen::Vector3f& p) const;
  /// eq. MAP-2: `doubt` matches share the error of a point's.
  double quality(const Eigen::Vector3f& p, double doubt) const {
    return plane_quality(count_, doubt, p - mean_, normal_, along_, longest_, shortest_);
  }

 private:
  std::uint32_t count_ = 0, next_fit_ = 0;
  Eigen::Vector3f sum_ = Eigen::Vector3f::Zero();
  std::array<float, 6> squares_{};  ///< xx, xy, xz, yy, yz, zz
  Eigen::Vector3f views_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal_ = Eigen::Vector3f::Zero(), mean_ = Eigen::Vector3f::Zero(), along_ = Eigen::Vector3f::Zero();
  float longest_ = 1, shortest_ = 1;  ///< variances within the plane [m^2]
  bool sided_ = false;
};

/// The plane that most of the first `count` points of a chunk lie on within `width` [m], by samples of three (RANSAC,
/// Fischler and Bolles 1981; the samples follow from `seed`), and refined once by a fit to those; lies_on[i] tells
/// which do. The number of them; 0 where there is none.
std::size_t most_common_plane(const Chunk& points, std::size_t count, float width, std::uint64_t seed,
                              std::span<std::uint8_t> lies_on);

}  // namespace aslio::plugins
