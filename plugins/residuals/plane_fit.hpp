#pragma once
/// Planes through small sets of points, many at once: closed form, structure of arrays, no branches in the arithmetic.

#include <cstddef>

#include "aslio/stages/map.hpp"

namespace aslio::plugins {

/// Up to kWidth planes. Coordinates are offsets from the respective query [m], small numbers; the arithmetic is double.
struct PlaneBatch {
  static constexpr std::size_t kWidth = 16;
  using Row = double[kWidth];

  Row x[Neighbours::kMax], y[Neighbours::kMax], z[Neighbours::kMax];  ///< in: [neighbour][plane]
  Row mean_x, mean_y, mean_z;                                         ///< out: centroid
  Row normal_x, normal_y, normal_z;  ///< out: unit normal, up to sign; not a number where there is none
  Row farthest;                      ///< out: largest distance of a neighbour to the plane [m]
  Row smallest, middle, largest;     ///< out: eigenvalues of the scatter / k [m^2]

  /// Least-squares planes of the first `k` neighbours (orthogonal distances): the normal is the eigenvector of the
  /// smallest eigenvalue of the scatter, from the adjugate of (scatter - eigenvalue). Pre: k >= 3.
  void fit(std::size_t k);
};

}  // namespace aslio::plugins
