#include "aslio/evaluation/alignment.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "aslio/core/errors.hpp"

namespace aslio::evaluation {

namespace {

/// First and second moments of the positions. eq. EVAL-4
struct Moments {
  Vec3 estimate = Vec3::Zero();
  Vec3 reference = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();  ///< of reference with estimate [m^2]
};

Moments moments(std::span<const PosePair> pairs, std::span<const double> weights) {
  Moments m;
  double total = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    total += weights[i];
    m.estimate += weights[i] * pairs[i].estimate.p;
    m.reference += weights[i] * pairs[i].reference.p;
  }
  m.estimate /= total;
  m.reference /= total;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    m.covariance +=
        (weights[i] / total) * (pairs[i].reference.p - m.reference) * (pairs[i].estimate.p - m.estimate).transpose();
  }
  return m;
}

/// Singular values below are zero: the absolute bound of evo, and what rounding leaves of a larger one.
double rank_threshold(double largest) { return std::max(std::numeric_limits<double>::epsilon(), 1e-13 * largest); }

Mat3 se3_rotation(const Mat3& covariance, std::size_t n) {
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3& d = svd.singularValues();
  if (d[1] <= rank_threshold(d[0])) {
    throw DataError(
        fmt::format("alignment se3: the {} matched positions lie on a line or in a point, which leaves the rotation "
                    "open; use a longer trajectory, or `aslio evaluate --alignment yaw` or none",
                    n));
  }
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

// eq. EVAL-5
Mat3 yaw_rotation(const Mat3& S, std::size_t n) {
  const double sine = S(1, 0) - S(0, 1);
  const double cosine = S(0, 0) + S(1, 1);
  if (std::hypot(sine, cosine) <= rank_threshold(S.norm())) {
    throw DataError(
        fmt::format("alignment yaw: the {} matched positions lie on a vertical line or in a point, which leaves the "
                    "yaw open; use a longer trajectory, or `aslio evaluate --alignment none`",
                    n));
  }
  return exp_so3(Vec3(0.0, 0.0, std::atan2(sine, cosine)));
}

}  // namespace

Pose align(Alignment alignment, std::span<const PosePair> pairs, std::span<const double> weights) {
  if (alignment == Alignment::none) return {};
  const Moments m = moments(pairs, weights);
  const Mat3 R =
      alignment == Alignment::se3 ? se3_rotation(m.covariance, pairs.size()) : yaw_rotation(m.covariance, pairs.size());
  return {R, m.reference - R * m.estimate};
}

double determining_spread(Alignment alignment, std::span<const PosePair> pairs, std::span<const double> weights) {
  if (alignment == Alignment::none) return std::numeric_limits<double>::infinity();
  const Vec3 mean = moments(pairs, weights).reference;
  Mat3 covariance = Mat3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec3 offset = pairs[i].reference.p - mean;
    covariance += weights[i] * offset * offset.transpose();
    total += weights[i];
  }
  if (alignment == Alignment::yaw) return std::sqrt((covariance(0, 0) + covariance(1, 1)) / total);
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance / total, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
}

Mat3 nearest_rotation(const Mat3& M) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace aslio::evaluation
