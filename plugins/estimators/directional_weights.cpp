#include "estimators/directional_weights.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "aslio/core/lie.hpp"

namespace aslio::plugins {

namespace {

/// Information that counts in full: so many times what the errors of the normals make.
constexpr double kClear = 10.0;
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

/// Share that counts of `seen`, of which `error` is what errors make alone: 0 up to there, 1 from kClear times it on.
/// In between it grows as the part that is no error. eq. IESKF-12.
double share_of(double seen, double error) {
  if (!(seen > error)) return 0.0;
  return std::min(1.0, (1.0 - error / seen) / (1.0 - 1.0 / kClear));
}

/// sum w G G^T with G = [[p]x R^T; I]: what the rows would see if their normals pointed everywhere.
struct Reach {
  double w = 0;
  Vec3 wp = Vec3::Zero();
  Mat3 wpp = Mat3::Zero();

  void add(const Vec3& p, double weight) {
    const Vec3 weighted = weight * p;
    w += weight;
    wp += weighted;
    wpp.noalias() += weighted * p.transpose();
  }
  Mat6 matrix(const Mat3& R) const {
    Mat6 M;
    M.topLeftCorner<3, 3>() = wpp.trace() * Mat3::Identity() - wpp;
    M.topRightCorner<3, 3>() = hat(wp) * R.transpose();
    M.bottomLeftCorner<3, 3>() = M.topRightCorner<3, 3>().transpose();
    M.bottomRightCorner<3, 3>() = w * Mat3::Identity();
    return M;
  }
};

/// Covariance of a plane's normal u, by the neighbours to which it is fitted: s^2/k (C + s^2/k)^-1 across u, C their
/// covariance [rad^2]. Neighbours in a line leave one angle open, up to 1 rad. eq. IESKF-12.
Mat3 fitted_covariance(const Neighbours& neighbours, std::size_t i, double s, const Vec3& u) {
  const std::size_t k = std::min<std::size_t>(neighbours.count[i], neighbours.k());
  if (k < 3) return Mat3::Zero();
  const double share = 1.0 / static_cast<double>(k);
  const Vec3 a = u.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> across;
  across << a, u.cross(a);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j < k; ++j) {
    const Eigen::Vector2d at = across.transpose() * neighbours.offset(i, j).cast<double>();
    mean += share * at;
    C += share * at * at.transpose();
  }
  const double noise = s * s * share;
  C += noise * Eigen::Matrix2d::Identity() - mean * mean.transpose();
  return noise * across * C.inverse() * across.transpose();
}

/// Noise of the points to which planes are fitted, by how far they lie from them, at most `most` [m]. Three of k are
/// what a plane takes. eq. IESKF-12.
double thickness(const DirectionalWeights::Rows& rows, double most) {
  double sum = 0, planes = 0;
  rows.set.each_row(rows.per_match, kEverywhere, [&](std::size_t i, const ResidualRow& row, double) {
    const Neighbours& neighbours = rows.set.neighbours;
    const std::size_t k = std::min<std::size_t>(neighbours.count[i], neighbours.k());
    if (k <= 3) return;
    double mean = 0, squares = 0;
    for (std::size_t j = 0; j < k; ++j) {
      const double off = row.J.dot(neighbours.offset(i, j).cast<double>());
      mean += off / static_cast<double>(k);
      squares += off * off;
    }
    sum += (squares - static_cast<double>(k) * mean * mean) / static_cast<double>(k - 3);
    planes += 1;
  });
  return planes > 0 ? std::min(most, std::sqrt(std::max(sum / planes, 0.0))) : most;
}

}  // namespace

DirectionalWeights::DirectionalWeights(const Params& params)
    : rule_(params.rule), variance_(std::pow(params.normal_error * kRadPerDeg, 2)) {}

void DirectionalWeights::find(const Rows& fresh, const Mat6& A) {
  count_ = 0;
  if (!active() || !A.allFinite()) return;
  const WindowMatches& set = fresh.set;
  const double noise = fresh.fitted_to > 0.0 ? thickness(fresh, fresh.fitted_to) : 0.0;
  Reach reach;
  Mat6 fitted = Mat6::Zero();
  set.each_row(fresh.per_match, kEverywhere, [&](std::size_t i, const ResidualRow& row, double information) {
    const double of_end = set.share.empty() ? 1.0 : set.share[i];
    const double weight = information * of_end * of_end;
    reach.add(set.body[i], weight);
    if (noise <= 0.0) return;
    Eigen::Matrix<double, 6, 3> G;
    G << hat(set.body[i]) * fresh.R.transpose(), Mat3::Identity();
    const Mat3 error = fitted_covariance(set.neighbours, i, noise, row.J);
    fitted.noalias() += weight * G * error * G.transpose();
  });
  // A rotation counts at a lever arm of 5 m, as in IESKF-7: only for the condition of the matrices.
  Vec6 scale;
  scale << Vec3::Constant(0.2), Vec3::Ones();
  const Mat6 seen = scale.asDiagonal() * A * scale.asDiagonal();
  const Mat6 made_up = variance_ * (reach.matrix(fresh.R) - A) + fitted;
  const Mat6 error = scale.asDiagonal() * made_up * scale.asDiagonal();
  const double size = seen.trace();
  if (!(size > 0.0) || !error.allFinite()) return;
  const Mat6 both = seen + error + 1e-12 * size * Mat6::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat6> solver(error, both);
  if (solver.info() != Eigen::Success || !solver.eigenvectors().allFinite()) return;
  for (int k = 0; k < 6; ++k) {
    const double part = std::clamp(solver.eigenvalues()[k], 0.0, 1.0);
    const double share = share_of(1.0 - part, part);
    if (share >= 1.0) continue;
    Direction& weak = directions_[static_cast<std::size_t>(count_++)];
    weak.v = scale.cwiseProduct(solver.eigenvectors().col(k));
    weak.information = 1.0 - part;
    weak.share = share;
  }
}

SeenMatrix DirectionalWeights::damping(const SeenMatrix& A) const {
  constexpr double least = 1e-6;  // of a share and of an information: 1 / 0 is no variance
  Mat6 Q = Mat6::Zero();
  for (int k = 0; k < count_; ++k) {
    const Direction& weak = directions_[static_cast<std::size_t>(k)];
    const double share = std::max(weak.share, least);
    Q += (1.0 - share) / (share * std::max(weak.information, least)) * weak.v * weak.v.transpose();
  }
  const Mat6 W = (Mat6::Identity() + Q * A.topLeftCorner<6, 6>()).partialPivLu().solve(Q);
  SeenMatrix L = SeenMatrix::Identity();
  L.leftCols<6>() -= A.leftCols<6>() * W;
  return L;
}

void DirectionalWeights::describe(config::Binder& b, Params& p) {
  b.choice(
      "directional", p.rule, {{"none", Rule::none}, {"damped", Rule::damped}},
      "damped: a direction of the pose counts less the more of its information may come from errors of the normals. "
      "none: all count in full");
  b.real("normal_error", p.normal_error, "deg", {.above = 0, .max = 30},
         "directional: standard deviation of a normal about each of its two axes, beside what the spread of its "
         "neighbours leaves open (planes: neighbours)");
}

}  // namespace aslio::plugins
