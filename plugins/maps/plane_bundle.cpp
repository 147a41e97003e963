#include "maps/plane_bundle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace aslio::plugins {

namespace {

/// Gap of the two least eigenvalues over the largest one below which a plane has no normal.
constexpr double kLeastGap = 1e-9;
/// Factors of the damping (Levenberg, Marquardt): the first, its growth, and the largest.
constexpr double kFirstDamping = 1e-6, kDampingGrowth = 10, kLargestDamping = 1e4;

/// Angle and distance of a pose from another one, and what a motion of it does to the angle.
struct Offset {
  Vec6 value;
  Mat3 turning;  ///< J_r^-1
};

Offset offset_of(const Mat3& turn, const Vec3& shift) {
  Offset out;
  const Vec3 angle = log_so3(turn);
  out.value << angle, shift;
  out.turning = right_jacobian_inverse_so3(angle);
  return out;
}

Offset from_increment(const Pose& from, const Pose& to, const Pose& measured) {
  return offset_of(measured.R.transpose() * (from.R.transpose() * to.R),
                   from.R.transpose() * (to.p - from.p) - measured.p);
}

Offset from_prior(const Pose& pose, const Pose& mean) {
  return offset_of(mean.R.transpose() * pose.R, pose.p - mean.p);
}

Eigen::Index at(std::uint32_t pose) { return 6 * static_cast<Eigen::Index>(pose); }

}  // namespace

/// The points of a plane at some poses.
struct PlaneBundle::Shape {
  Vec3 mean, variance;  ///< variances ascending, times the number of points
  Mat3 axes;            ///< the first is the normal
  double n = 0;
};

void PlaneBundle::clear() {
  poses_.clear();
  planes_.clear();
  clusters_.clear();
  increments_.clear();
  priors_.clear();
}

std::uint32_t PlaneBundle::add_pose(const Pose& pose) {
  poses_.push_back(pose);
  return static_cast<std::uint32_t>(poses_.size() - 1);
}

void PlaneBundle::add_plane(const PointMoments& fixed, std::span<const Cluster> clusters) {
  const std::size_t begin = clusters_.size();
  clusters_.insert(clusters_.end(), clusters.begin(), clusters.end());
  planes_.push_back({fixed, begin, clusters_.size()});
}

void PlaneBundle::add_increment(std::uint32_t from, std::uint32_t to, const Pose& measured, const Mat6& information) {
  increments_.push_back({from, to, measured, information});
}

void PlaneBundle::add_prior(std::uint32_t pose, const Pose& mean, const Mat6& information) {
  priors_.push_back({pose, mean, information});
}

/// False for a plane that has no normal.
bool PlaneBundle::shape_of(const Plane& plane, const std::vector<Pose>& poses, Shape& out) const {
  PointMoments all = plane.fixed;
  for (std::size_t c = plane.begin; c < plane.end; ++c) all += clusters_[c].points.moved(poses[clusters_[c].pose]);
  if (!(all.n > 0)) return false;
  const Mat3 scatter = all.scatter();
  if (!scatter.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scatter);
  out.mean = all.mean();
  out.variance = solver.eigenvalues();
  out.axes = solver.eigenvectors();
  out.n = all.n;
  return out.variance[1] - out.variance[0] > kLeastGap * out.variance[2];
}

double PlaneBundle::cost(const std::vector<Pose>& poses) const {
  double sum = 0;
  Shape shape;
  for (const Plane& plane : planes_)
    if (shape_of(plane, poses, shape)) sum += shape.variance[0];
  for (const Increment& i : increments_) {
    const Vec6 r = from_increment(poses[i.from], poses[i.to], i.measured).value;
    sum += r.dot(i.information * r);
  }
  for (const Prior& prior : priors_) {
    const Vec6 r = from_prior(poses[prior.pose], prior.mean).value;
    sum += r.dot(prior.information * r);
  }
  return sum;
}

/// eq. MAP-11: adds slope and curvature of the least eigenvalue of one plane; the eigenvalue.
double PlaneBundle::plane_term(const Plane& plane, const std::vector<Pose>& poses, std::vector<Coupling>& coupled,
                               Eigen::VectorXd& slope, Eigen::MatrixXd& curvature) const {
  Shape shape;
  if (!shape_of(plane, poses, shape)) return 0;
  const Vec3 u = shape.axes.col(0);
  // What couples the poses: the plane shifts and tilts with them.
  coupled.resize(plane.end - plane.begin);
  const Vec3 share(-2.0 / shape.n, 2.0 / (shape.variance[0] - shape.variance[1]),
                   2.0 / (shape.variance[0] - shape.variance[2]));
  for (std::size_t c = plane.begin; c < plane.end; ++c) {
    const PointMoments& points = clusters_[c].points;
    const Pose& pose = poses[clusters_[c].pose];
    const Mat3 S = points.squares();
    const Vec3 a = pose.R.transpose() * u, lever = pose.p - shape.mean;
    const double h = u.dot(lever);
    const Vec3 off = S * a + h * points.sum;  // sum of e b over the points, e their distance from the plane
    const double off_sum = a.dot(points.sum) + h * points.n;
    const Eigen::Index i = at(clusters_[c].pose);
    slope.segment<3>(i) += 2.0 * off.cross(a);
    slope.segment<3>(i + 3) += 2.0 * off_sum * u;

    const Mat3 A = hat(a), both = a * off.transpose();
    const Vec3 turned = points.sum.cross(a);
    auto own = curvature.block<6, 6>(i, i);
    own.topLeftCorner<3, 3>() += 2.0 * A * S * A.transpose() + both + both.transpose();
    own.topLeftCorner<3, 3>().diagonal().array() -= 2.0 * a.dot(off);
    own.bottomLeftCorner<3, 3>() += 2.0 * u * turned.transpose();
    own.topRightCorner<3, 3>() += 2.0 * turned * u.transpose();
    own.bottomRightCorner<3, 3>() += 2.0 * points.n * u * u.transpose();

    Coupling& q = coupled[c - plane.begin];
    q.col(0) << turned, points.n * u;
    for (int k = 1; k < 3; ++k) {
      const Vec3 axis = shape.axes.col(k), along = pose.R.transpose() * axis;
      const double reach = axis.dot(lever);
      const Vec3 moment = S * along + reach * points.sum;
      q.col(k) << moment.cross(a) + off.cross(along), (along.dot(points.sum) + reach * points.n) * u + off_sum * axis;
    }
  }
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const Coupling weighted = coupled[i] * share.asDiagonal();
    const Eigen::Index row = at(clusters_[plane.begin + i].pose);
    for (std::size_t j = 0; j < coupled.size(); ++j)
      curvature.block<6, 6>(row, at(clusters_[plane.begin + j].pose)).noalias() += weighted * coupled[j].transpose();
  }
  return shape.variance[0];
}

double PlaneBundle::linearise(const std::vector<Pose>& poses, Eigen::VectorXd& slope,
                              Eigen::MatrixXd& curvature) const {
  const auto size = 6 * static_cast<Eigen::Index>(poses.size());
  slope.setZero(size);
  curvature.setZero(size, size);
  double sum = 0;
  std::vector<Coupling> coupled;
  for (const Plane& plane : planes_) sum += plane_term(plane, poses, coupled, slope, curvature);
  for (const Increment& i : increments_) {
    const Pose &from = poses[i.from], &to = poses[i.to];
    const Offset offset = from_increment(from, to, i.measured);
    Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
    J.block<3, 3>(0, 0) = -offset.turning * to.R.transpose() * from.R;
    J.block<3, 3>(0, 6) = offset.turning;
    J.block<3, 3>(3, 0) = hat(from.R.transpose() * (to.p - from.p));
    J.block<3, 3>(3, 3) = -from.R.transpose();
    J.block<3, 3>(3, 9) = from.R.transpose();
    const Eigen::Matrix<double, 12, 6> known = 2.0 * J.transpose() * i.information;
    const Eigen::Matrix<double, 12, 1> pull = known * offset.value;
    const Eigen::Matrix<double, 12, 12> both = known * J;
    const Eigen::Index a = at(i.from), b = at(i.to);
    slope.segment<6>(a) += pull.head<6>();
    slope.segment<6>(b) += pull.tail<6>();
    curvature.block<6, 6>(a, a) += both.topLeftCorner<6, 6>();
    curvature.block<6, 6>(a, b) += both.topRightCorner<6, 6>();
    curvature.block<6, 6>(b, a) += both.bottomLeftCorner<6, 6>();
    curvature.block<6, 6>(b, b) += both.bottomRightCorner<6, 6>();
    sum += offset.value.dot(i.information * offset.value);
  }
  for (const Prior& prior : priors_) {
    const Offset offset = from_prior(poses[prior.pose], prior.mean);
    Mat6 J = Mat6::Identity();
    J.topLeftCorner<3, 3>() = offset.turning;
    const Mat6 known = 2.0 * J.transpose() * prior.information;
    slope.segment<6>(at(prior.pose)) += known * offset.value;
    curvature.block<6, 6>(at(prior.pose), at(prior.pose)) += known * J;
    sum += offset.value.dot(prior.information * offset.value);
  }
  return sum;
}

/// Poses one step further, in tried_; false when the curvature with this damping has no least point.
bool PlaneBundle::step(const Eigen::VectorXd& slope, const Eigen::MatrixXd& curvature, double damping) {
  Eigen::MatrixXd damped = curvature;
  damped.diagonal() += damping * curvature.diagonal().cwiseAbs();  // far from the planes a curvature may be negative
  const Eigen::LLT<Eigen::MatrixXd> solver(damped);
  if (solver.info() != Eigen::Success) return false;
  move_ = -solver.solve(slope);
  if (!move_.allFinite()) return false;
  tried_.resize(poses_.size());
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Vec6 move = move_.segment<6>(at(static_cast<std::uint32_t>(i)));
    tried_[i] = poses_[i].moved(move);
    tried_[i].R = orthonormalised(tried_[i].R);
  }
  return true;
}

PlaneBundle::Result PlaneBundle::solve() {
  Result result;
  if (poses_.empty()) return result;
  double sum = linearise(poses_, slope_, curvature_), damping = 0;
  result.before = result.after = sum;
  if (!std::isfinite(sum) || !slope_.allFinite() || !curvature_.allFinite()) {
    result.outcome = Outcome::failed;
    return result;
  }
  result.outcome = Outcome::stopped;
  while (result.steps < params_.max_iterations) {
    const bool found = step(slope_, curvature_, damping);
    if (found && move_.norm() < params_.converged) {
      result.outcome = Outcome::converged;
      return result;
    }
    const double there = found ? cost(tried_) : std::numeric_limits<double>::infinity();
    if (!(there <= sum)) {
      damping = std::max(kFirstDamping, kDampingGrowth * damping);
      if (damping > kLargestDamping) {
        result.outcome = Outcome::failed;
        return result;
      }
      continue;
    }
    damping /= kDampingGrowth;
    poses_.swap(tried_);
    ++result.steps;
    result.after = sum = result.steps < params_.max_iterations ? linearise(poses_, slope_, curvature_) : there;
  }
  return result;
}

}  // namespace aslio::plugins
