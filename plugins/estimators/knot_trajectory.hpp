#pragma once
/// T_W_I as a filter found it that was corrected many times inside one window.

#include <span>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

/// Knots are the states after each correction; between them each is carried on with its own rate, velocity and world
/// acceleration. Unknowns: the poses of the knots, in time order. eq. TRJ-3.
class KnotTrajectory final : public TrajectoryModel {
 public:
  void clear() { knots_.clear(); }
  void reserve(std::size_t knots) { knots_.reserve(knots); }
  std::size_t capacity() const { return knots_.capacity(); }
  /// Pre: not earlier than the last knot, and at a constant rate; one of the same time takes its place.
  void append(const MotionSegment& knot);
  std::span<const MotionSegment> knots() const { return knots_; }

  /// Pre: there is a knot. Before the first, its pose.
  Pose pose(TimeNs t) const override;
  int dof() const override { return 6 * static_cast<int>(knots_.size()); }
  Pose moved(TimeNs t, const Eigen::VectorXd& xi) const override;
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  std::size_t knot_of(TimeNs t) const;

  std::vector<MotionSegment> knots_;
};

}  // namespace aslio::plugins
