#pragma once
/// T_W_I over a window as a spline of control poses (docs/equations.md SPL-9).

#include <vector>

#include "aslio/stages/estimator.hpp"
#include "estimators/spline_state.hpp"

namespace aslio::plugins {

/// Unknowns, in time order: the control poses that no later measurement moves, then the pose at the end of the window,
/// which takes the last four control poses along as one body.
class SplineTrajectory final : public TrajectoryModel {
 public:
  void reserve(std::size_t control_poses) { control_.reserve(control_poses); }
  std::size_t capacity() const { return control_.capacity(); }
  /// Begins with the segment of `x`.
  void begin(const SplineState& x);
  /// The last four control poses are those of `x`, which may have moved on by one segment.
  void follow(const SplineState& x);
  /// The window ends at t. Pre: begin().
  void close(TimeNs t);
  /// Every position on the line through that of the end, with velocity v [m/s]. Pre: close().
  void straighten(const Vec3& v);
  /// Begins of segments, in time order: as many as segments.
  std::size_t segments() const { return control_.size() - 3; }
  TimeNs begin_of(std::size_t segment) const { return begin_ + static_cast<TimeNs>(segment) * interval_; }
  SplineMoment moment(TimeNs t) const;

  /// Before the first segment its begin, after the last its end.
  Pose pose(TimeNs t) const override;
  int dof() const override { return 6 * static_cast<int>(control_.size()) - 18; }
  Pose moved(TimeNs t, const Eigen::VectorXd& xi) const override;
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  std::size_t segment_of(TimeNs t) const;
  double share(TimeNs t, std::size_t segment) const;
  ControlPoses control_of(std::size_t segment) const;
  CubicSplineSegment made_of(const ControlPoses& control) const { return {control, to_seconds(interval_)}; }
  std::size_t free_poses() const { return control_.size() - 4; }  ///< that no later measurement moves

  TimeNs begin_ = 0, interval_ = 1, end_ = 0;
  std::vector<Pose> control_;
};

}  // namespace aslio::plugins
