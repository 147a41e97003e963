#include "maps/sampled_plane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

namespace {

/// Of the variances along the two directions of a plane: a line spans none. As in MAP-1.
constexpr float kMinSpread = 0.05F;
/// Of a direction in the plane to the thickness: a clump spans none. As in MAP-1, in variances.
constexpr float kMinAspect = 9;
/// Error of a variance summed up in floats, in units of the squared edge of the coarsest voxels.
constexpr float kRounding = 1e-6F;
/// Growth of the count that is worth a new fit.
constexpr double kRefit = 1.1;
/// Samples of three. With half of the points on the plane, one in eight is free of others: 24 miss it in 4 % of cases.
constexpr std::size_t kSamples = 24;

Eigen::Vector3f point(const Chunk& points, std::size_t i) { return {points.x[i], points.y[i], points.z[i]}; }

struct Axes {
  Vec3 variances, mean;  ///< ascending
  Mat3 directions;
};

Axes axes_of(const Eigen::Vector3f& sum, const std::array<float, 6>& s, double n) {
  Axes axes;
  axes.mean = sum.cast<double>() / n;
  Eigen::Matrix3f squares;
  squares << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  const Mat3 covariance = squares.cast<double>() / n - axes.mean * axes.mean.transpose();
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(covariance);
  axes.variances = solver.eigenvalues();
  axes.directions = solver.eigenvectors();
  return axes;
}

struct Candidate {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float offset = 0;  ///< normal . p of its points
};

std::size_t count_near(const Chunk& points, std::size_t count, const Candidate& plane, float width) {
  std::size_t near = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float d = plane.normal.x() * points.x[i] + plane.normal.y() * points.y[i] + plane.normal.z() * points.z[i];
    near += std::abs(d - plane.offset) <= width ? 1U : 0U;
  }
  return near;
}

}  // namespace

void SampledPlane::add(const Eigen::Vector3f& p, const Eigen::Vector3f& toward) {
  ++count_;
  sum_ += p;
  std::size_t k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) squares_[k++] += p[i] * p[j];
  views_ += toward;
}

// eq. MAP-1.
bool SampledPlane::fit(const Limits& limits) {
  next_fit_ = static_cast<std::uint32_t>(kRefit * count_) + 1;
  if (count_ < 4) return false;
  const Axes axes = axes_of(sum_, squares_, count_);
  const double thin = std::max(axes.variances[0], static_cast<double>(kRounding * limits.edge * limits.edge));
  if (!axes.directions.allFinite() || axes.variances[0] >= limits.thickness * limits.thickness ||
      axes.variances[1] <= kMinSpread * axes.variances[2] || axes.variances[1] <= kMinAspect * thin) {
    return false;
  }
  mean_ = axes.mean.cast<float>();
  normal_ = axes.directions.col(0).cast<float>();
  along_ = axes.directions.col(2).cast<float>();
  longest_ = static_cast<float>(axes.variances[2]);
  shortest_ = static_cast<float>(axes.variances[1]);
  const float away = views_.dot(normal_);
  sided_ = away != 0;
  if (away > 0) normal_ = -normal_;
  return true;
}

float SampledPlane::reach(const Eigen::Vector3f& p) const {
  const Eigen::Vector3f d = p - mean_;
  const float across = d.dot(normal_), along = d.dot(along_);
  const float rest = std::max(0.0F, d.squaredNorm() - across * across - along * along);
  return along * along / longest_ + rest / shortest_;
}

double SampledPlane::quality(const Eigen::Vector3f& p, double doubt) const {
  return count_ / (count_ + doubt * (1.0 + static_cast<double>(reach(p))));
}

std::size_t most_common_plane(const Chunk& points, std::size_t count, float width, std::uint64_t seed,
                              std::span<std::uint8_t> lies_on) {
  Candidate best;
  std::size_t most = 0;
  for (std::size_t k = 0; k < kSamples && count >= 3; ++k) {
    const auto pick = [&](std::uint64_t which) { return mixed(seed + 3 * k + which) % count; };
    const Eigen::Vector3f a = point(points, pick(0)), b = point(points, pick(1)), c = point(points, pick(2));
    const Eigen::Vector3f normal = (b - a).cross(c - a);
    if (!(normal.norm() > 1e-6F)) continue;  // one point twice, or a line
    Candidate found{normal.normalized(), 0};
    found.offset = found.normal.dot(a);
    const std::size_t near = count_near(points, count, found, width);
    if (near <= most) continue;
    most = near;
    best = found;
  }
  if (most < 4) return 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::array<float, 6> squares{};
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p = point(points, i);
    if (std::abs(best.normal.dot(p) - best.offset) > width) continue;
    sum += p;
    std::size_t at = 0;
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column) squares[at++] += p[row] * p[column];
  }
  const Axes axes = axes_of(sum, squares, static_cast<double>(most));
  if (axes.directions.allFinite()) {
    best.normal = axes.directions.col(0).cast<float>();
    best.offset = best.normal.dot(axes.mean.cast<float>());
  }
  std::size_t near = 0;
  for (std::size_t i = 0; i < count; ++i) {
    lies_on[i] = std::abs(best.normal.dot(point(points, i)) - best.offset) <= width ? 1 : 0;
    near += lies_on[i];
  }
  return near;
}

}  // namespace aslio::plugins
