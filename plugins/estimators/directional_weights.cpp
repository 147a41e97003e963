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

}  // namespace

DirectionalWeights::DirectionalWeights(const Params& params)
    : rule_(params.rule), variance_(std::pow(params.normal_error * kRadPerDeg, 2)) {}

void DirectionalWeights::find(const WindowMatches& fresh, std::size_t rows_per_match, const Mat6& A, const Mat3& R) {
  count_ = 0;
  if (!active() || !A.allFinite()) return;
  Reach reach;
  fresh.each_row(rows_per_match, std::numeric_limits<double>::infinity(),
                 [&](std::size_t i, const ResidualRow&, double information) {
                   const double seen = fresh.share.empty() ? 1.0 : fresh.share[i];
                   reach.add(fresh.body[i], information * seen * seen);
                 });
  // A rotation counts at a lever arm of 5 m, as in IESKF-7: only for the condition of the matrices.
  Vec6 scale;
  scale << Vec3::Constant(0.2), Vec3::Ones();
  const Mat6 seen = scale.asDiagonal() * A * scale.asDiagonal();
  const Mat6 error = variance_ * (scale.asDiagonal() * reach.matrix(R) * scale.asDiagonal() - seen);
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
    const Vec6 v = solver.eigenvectors().col(k);
    weak.v = scale.cwiseProduct(v);
    weak.dual = (both * v).cwiseQuotient(scale);
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

/// The row [(p x R^T u)^T, u^T] without what its normal does not show of the weak directions.
Vec6 DirectionalWeights::reduced(const Vec3& p_I, const Vec3& u, const Mat3& R) const {
  Vec6 h;
  h << p_I.cross(R.transpose() * u), u;
  Vec6 out = h;
  for (int k = 0; k < count_; ++k) {
    const Direction& weak = directions_[static_cast<std::size_t>(k)];
    const Vec3 moved = R * weak.v.head<3>().cross(p_I) + weak.v.tail<3>();  // of the point, along the direction
    const double seen = std::pow(h.dot(weak.v), 2);
    const double error = variance_ * std::max(moved.squaredNorm() - seen, 0.0);
    const double kept = weak.share + (1.0 - weak.share) * share_of(seen, error);
    out -= (1.0 - kept) * h.dot(weak.v) * weak.dual;
  }
  return out;
}

void DirectionalWeights::select(const WindowMatches& set, std::size_t rows_per_match, double gate, const Mat3& R,
                                WindowInformation& sum) const {
  WindowInformation kept;
  set.each_row(rows_per_match, gate, [&](std::size_t i, const ResidualRow& row, double information) {
    const double of_end = set.share.empty() ? 1.0 : set.share[i];
    const Vec6 h = of_end * reduced(set.body[i], row.J, R);
    const Vec6 weighted = information * h;
    kept.A.noalias() += weighted * h.transpose();
    kept.b += row.r * weighted;
    if (set.lag.empty()) return;
    const Vec6 later = set.lag[i] * weighted;
    kept.A1.noalias() += later * h.transpose();
    kept.A2.noalias() += set.lag[i] * later * h.transpose();
    kept.b1 += row.r * later;
  });
  sum.A = kept.A;
  sum.b = kept.b;
  sum.A1 = kept.A1;
  sum.A2 = kept.A2;
  sum.b1 = kept.b1;
}

void DirectionalWeights::describe(config::Binder& b, Params& p) {
  b.choice(
      "directional", p.rule, {{"none", Rule::none}, {"damped", Rule::damped}, {"selected", Rule::selected}},
      "weights by direction of the pose, where errors of the normals may make up what the points seem to see of it. "
      "none: all count. damped: the whole direction counts less. selected: along it only points count whose normal "
      "shows it beyond its error");
  b.real(
      "normal_error", p.normal_error, "deg", {.above = 0, .max = 30},
      "directional: standard deviation of a normal about each of its two axes; ten times the information that it makes "
      "counts in full");
}

}  // namespace aslio::plugins
