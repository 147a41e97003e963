#include "maps/plane_shape.hpp"

#include <Eigen/Eigenvalues>

namespace aslio::plugins {

namespace {

/// Of the variances along the two directions of a plane: a line spans none.
constexpr double kMinSpread = 0.05;
/// Of a direction in the plane to the thickness: a clump spans none.
constexpr double kMinAspect = 9;
/// The same where noise makes planes thick: in a voxel of 0.5 m, 9 is more than any plane has with 5 cm of noise.
constexpr double kMinNoisyAspect = 2;

}  // namespace

double least_aspect(double noise_scale) {
  return std::clamp(kMinAspect / (noise_scale * noise_scale), kMinNoisyAspect, kMinAspect);
}

PlaneShape plane_shape(const Mat3& covariance, const PlaneLimits& limits) {
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(covariance);
  const Vec3& variance = solver.eigenvalues();  // ascending
  const double thin = std::max(variance[0], limits.rounding);
  const bool planar = variance[0] < limits.thickness * limits.thickness && variance[1] > kMinSpread * variance[2] &&
                      variance[1] > limits.aspect * thin && solver.eigenvectors().allFinite();
  return {solver.eigenvectors().col(0), solver.eigenvectors().col(2), variance, planar};
}

}  // namespace aslio::plugins
