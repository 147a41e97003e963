#include "estimators/knot_trajectory.hpp"

#include <algorithm>

namespace aslio::plugins {

void KnotTrajectory::append(const MotionSegment& knot) {
  if (!knots_.empty() && knots_.back().t == knot.t) {
    knots_.back() = knot;
  } else {
    knots_.push_back(knot);
  }
}

std::size_t KnotTrajectory::knot_of(TimeNs t) const {
  const auto later = std::upper_bound(knots_.begin(), knots_.end(), t,
                                      [](TimeNs at, const MotionSegment& knot) { return at < knot.t; });
  return later == knots_.begin() ? 0 : static_cast<std::size_t>(later - knots_.begin() - 1);
}

Pose KnotTrajectory::pose(TimeNs t) const {
  const MotionSegment& knot = knots_[knot_of(t)];
  return knot.pose(std::max(t, knot.t));
}

Pose KnotTrajectory::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  const std::size_t k = knot_of(t);
  MotionSegment knot = knots_[k];
  const Pose start = Pose{knot.R, knot.p}.moved(xi.segment<6>(static_cast<Eigen::Index>(6 * k)));
  knot.R = start.R;
  knot.p = start.p;
  return knot.pose(std::max(t, knot.t));
}

// eq. TRJ-3.
void KnotTrajectory::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  const std::size_t k = knot_of(t);
  const MotionSegment& knot = knots_[k];
  out.resize(6, dof());
  out.setZero();
  const auto column = static_cast<Eigen::Index>(6 * k);
  out.block<3, 3>(0, column) = exp_so3(-to_seconds(std::max(t, knot.t) - knot.t) * knot.w);
  out.block<3, 3>(3, column + 3) = Mat3::Identity();
}

}  // namespace aslio::plugins
