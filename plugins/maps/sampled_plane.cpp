#include "maps/sampled_plane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "aslio/core/spread.hpp"

namespace aslio::plugins {

namespace {

/// Points whose sums in floats err by kRounding; of more, the error grows as fast as their square at most.
constexpr double kRoundingPoints = 500;
/// Samples of three. With half of the points on the plane, one in eight is free of others: 24 miss it in 4 % of cases.
constexpr std::size_t kSamples = 24;

Eigen::Vector3f point(const Chunk& points, std::size_t i) { return {points.x[i], points.y[i], points.z[i]}; }

struct Moments {
  Vec3 mean;
  Mat3 covariance;
};

Moments moments_of(const Eigen::Vector3f& sum, const std::array<float, 6>& s, double n) {
  const Vec3 mean = sum.cast<double>() / n;
  Eigen::Matrix3f squares;
  squares << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return {mean, squares.cast<double>() / n - mean * mean.transpose()};
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
bool SampledPlane::fit(double thickness, double aspect, double edge) {
  const double n = count_;
  next_fit_ = static_cast<std::uint32_t>(kRefit * n) + 1;
  if (count_ < 4) return false;
  const Moments moments = moments_of(sum_, squares_, n);
  const double rounding = kRounding * std::max(1.0, std::pow(n / kRoundingPoints, 2)) * edge * edge;
  const PlaneShape shape = plane_shape(moments.covariance, {thickness, aspect, rounding});
  if (!shape.planar) return false;
  mean_ = moments.mean.cast<float>();
  normal_ = shape.normal.cast<float>();
  along_ = shape.along.cast<float>();
  longest_ = static_cast<float>(shape.variance[2]);
  shortest_ = static_cast<float>(shape.variance[1]);
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
  const Moments moments = moments_of(sum, squares, static_cast<double>(most));
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(moments.covariance);
  if (solver.eigenvectors().allFinite()) {
    best.normal = solver.eigenvectors().col(0).cast<float>();
    best.offset = best.normal.dot(moments.mean.cast<float>());
  }
  std::size_t near = 0;
  for (std::size_t i = 0; i < count; ++i) {
    lies_on[i] = std::abs(best.normal.dot(point(points, i)) - best.offset) <= width ? 1 : 0;
    near += lies_on[i];
  }
  return near;
}

}  // namespace aslio::plugins
