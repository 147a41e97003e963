#include "aslio/toolkit/window_trajectory.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace aslio {

void WindowTrajectory::clear(const NavState& start) {
  begin_ = start.t;
  segments_.clear();
  end_ = start;
  corrected_end_ = start.pose();
  turn_ = move_ = Vec3::Zero();
}

void WindowTrajectory::append(const MotionSegment& segment, const NavState& end) {
  segments_.push_back(segment);
  end_ = end;
  corrected_end_ = end.pose();
}

void WindowTrajectory::correct(const Pose& end) {
  corrected_end_ = end;
  turn_ = log_so3(end_.R.transpose() * end.R);
  move_ = end.R.transpose() * (end.p - end_.p);
}

void WindowTrajectory::correct_states(std::span<NavState> inside, const NavState& end) const {
  for (NavState& state : inside) {
    const double alpha = spread_ == Spread::rigid ? 1.0 : share(state.t);
    const Pose here = pose(state.t);
    const Vec3 v = state.v + alpha * (end.v - end_.v);
    const TimeNs t = state.t;
    state = end;
    state.t = t;
    state.R = here.R;
    state.p = here.p;
    state.v = v;
  }
}

void WindowTrajectory::shift(const Vec3& by) {
  for (MotionSegment& segment : segments_) segment.p += by;
  end_.p += by;
  corrected_end_.p += by;
}

void WindowTrajectory::move(const Pose& T) {
  for (MotionSegment& segment : segments_) {
    segment.R = T.R * segment.R;
    segment.p = T * segment.p;
    segment.v = T.R * segment.v;
    segment.a_W = T.R * segment.a_W;
  }
  end_.R = T.R * end_.R;
  end_.p = T * end_.p;
  corrected_end_ = T * corrected_end_;
}

double WindowTrajectory::share(TimeNs t) const {
  if (t >= end_.t) return 1.0;
  return t <= begin_ ? 0.0 : static_cast<double>(t - begin_) / static_cast<double>(end_.t - begin_);
}

Pose WindowTrajectory::end_at(double alpha) const {
  if (spread_ == Spread::rigid) return corrected_end_;
  return {end_.R * exp_so3(alpha * turn_), end_.p + alpha * (corrected_end_.p - end_.p)};
}

/// eq. DSK-2: T_k^-1 T_alpha p.
PointLanes WindowTrajectory::in_end(const PointLanes& p, const PointLanes::Lane& alpha) const {
  PointLanes::Lane rest{}, A{}, B{};  // of the correction, what is still to come
  for (std::size_t l = 0; l < rest.size(); ++l) rest[l] = alpha[l] - 1.0;
  turn_factors(turn_.squaredNorm(), rest, A, B);
  PointLanes out = p.turned(turn_, A, B);
  for (std::size_t l = 0; l < rest.size(); ++l) {
    out.x[l] += rest[l] * move_.x();
    out.y[l] += rest[l] * move_.y();
    out.z[l] += rest[l] * move_.z();
  }
  return out;
}

Pose WindowTrajectory::predicted(TimeNs t) const {
  if (segments_.empty() || t >= end_.t) return end_.pose();
  auto later = std::upper_bound(segments_.begin(), segments_.end(), t,
                                [](TimeNs at, const MotionSegment& segment) { return at < segment.t; });
  if (later == segments_.begin()) return segments_.front().pose(segments_.front().t);
  return std::prev(later)->pose(t);
}

Pose WindowTrajectory::pose(TimeNs t) const { return end_at(share(t)) * (end_.pose().inverse() * predicted(t)); }

Pose WindowTrajectory::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  WindowTrajectory other = *this;
  other.correct(corrected_end_.moved(xi.head<6>()));
  return other.pose(t);
}

void WindowTrajectory::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  // T(t) = T_alpha T_rel with T_rel fixed. eqs. TRJ-1, DSK-2.
  const Pose relative = end_.pose().inverse() * predicted(t);
  const double alpha = spread_ == Spread::rigid ? 1.0 : share(t);
  Mat3 turn = Mat3::Identity();  // of T_alpha per turn of the end
  if (spread_ == Spread::linear) {
    turn = alpha * right_jacobian_so3(alpha * turn_) * right_jacobian_so3(turn_).inverse();
  }
  out.resize(6, 6);
  out.setZero();
  out.topLeftCorner<3, 3>() = relative.R.transpose() * turn;
  out.bottomLeftCorner<3, 3>() = -end_at(alpha).R * hat(relative.p) * turn;
  out.bottomRightCorner<3, 3>() = alpha * Mat3::Identity();
}

}  // namespace aslio
