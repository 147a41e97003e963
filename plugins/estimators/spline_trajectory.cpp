#include "estimators/spline_trajectory.hpp"

#include <algorithm>

namespace aslio::plugins {

void SplineTrajectory::begin(const SplineState& x) {
  begin_ = end_ = x.begin;
  interval_ = x.interval;
  control_.assign(x.control.begin(), x.control.end());
}

void SplineTrajectory::follow(const SplineState& x) {
  if (x.begin > begin_of(segments())) return begin(x);  // moved on in one step, over a gap
  if (x.begin == begin_of(segments())) control_.push_back(x.control.back());
  std::copy(x.control.begin(), x.control.end(), control_.end() - 4);
}

void SplineTrajectory::close(TimeNs t) { end_ = t; }

void SplineTrajectory::straighten(const Vec3& v) {
  const Vec3 at_end = pose(end_).p;
  for (std::size_t i = 0; i < control_.size(); ++i) {
    control_[i].p = at_end + to_seconds(begin_of(i) - interval_ - end_) * v;
  }
}

std::size_t SplineTrajectory::segment_of(TimeNs t) const {
  const TimeNs passed = std::clamp<TimeNs>(t - begin_ - 1, 0, begin_of(segments()) - begin_ - 1);
  return static_cast<std::size_t>(passed / interval_);  // a knot belongs to the segment that it ends
}

double SplineTrajectory::share(TimeNs t, std::size_t segment) const {
  return std::clamp(to_seconds(t - begin_of(segment)) / to_seconds(interval_), 0.0, 1.0);
}

ControlPoses SplineTrajectory::control_of(std::size_t segment) const {
  ControlPoses out;
  std::copy_n(control_.begin() + static_cast<std::ptrdiff_t>(segment), 4, out.begin());
  return out;
}

Pose SplineTrajectory::pose(TimeNs t) const {
  const std::size_t k = segment_of(t);
  return made_of(control_of(k)).pose(share(t, k));
}

SplineMoment SplineTrajectory::moment(TimeNs t) const {
  const std::size_t k = segment_of(t);
  return made_of(control_of(k)).at(share(t, k));
}

Pose SplineTrajectory::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  const std::size_t k = segment_of(t);
  const Mat3 R_end = pose(end_).R;
  const Vec6 of_end = xi.tail<6>();
  const Mat3 turn = R_end * exp_so3(of_end.head<3>()) * R_end.transpose();
  ControlPoses control = control_of(k);
  for (std::size_t i = 0; i < 4; ++i) {
    if (k + i < free_poses()) {
      control[i] = control[i].moved(xi.segment<6>(static_cast<Eigen::Index>(6 * (k + i))));
    } else {
      control[i] = {turn * control[i].R, control[i].p + of_end.tail<3>()};
    }
  }
  return made_of(control).pose(share(t, k));
}

// eq. SPL-9.
void SplineTrajectory::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  const std::size_t k = segment_of(t);
  const Mat3 R_end = pose(end_).R;
  const ControlPoses control = control_of(k);
  const SplineSlopes slopes = made_of(control).slopes(share(t, k));
  out.resize(6, dof());
  out.setZero();
  for (std::size_t i = 0; i < 4; ++i) {
    const bool free = k + i < free_poses();
    const auto column = free ? static_cast<Eigen::Index>(6 * (k + i)) : out.cols() - 6;
    const Mat3 theta = free ? slopes.theta[i] : slopes.theta[i] * control[i].R.transpose() * R_end;
    out.block<3, 3>(0, column) += theta;
    out.block<3, 3>(3, column + 3).diagonal().array() += slopes.p[i];
  }
}

}  // namespace aslio::plugins
