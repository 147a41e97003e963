#pragma once
/// T_W_I over the fresh interval of one window, as predicted and after the correction of its end.

#include <algorithm>
#include <span>
#include <vector>

#include "aslio/stages/estimator.hpp"
#include "aslio/toolkit/point_lanes.hpp"

namespace aslio {

class WindowTrajectory final : public TrajectoryModel {
 public:
  /// How the correction delta of the end pose spreads over the interval.
  enum class Spread : std::uint8_t {
    rigid,  ///< all of it everywhere
    linear  ///< alpha delta, alpha rising from 0 at the begin of the interval to 1 at its end (eq. DSK-2)
  };

  explicit WindowTrajectory(Spread spread) : spread_(spread) {}
  void reserve(std::size_t segments) { segments_.reserve(segments); }
  void clear(const NavState& start);
  void append(const MotionSegment& segment, const NavState& end);
  /// Moves everything, e.g. once the end has been found to lie elsewhere.
  void shift(const Vec3& by);
  /// Moves everything by `T` (W from W), its correction included; velocities keep their frame but inside segments.
  void move(const Pose& T);
  /// The end pose after the update.
  void correct(const Pose& end);
  /// States that the prediction went through, in which the corrected `end` is known, too: on the corrected path, with
  /// the share of the velocity's correction that it has there, and the rest as at the end (eq. DSK-2).
  void correct_states(std::span<NavState> inside, const NavState& end) const;

  Spread spread() const { return spread_; }
  std::span<const MotionSegment> segments() const { return segments_; }
  const NavState& predicted_end() const { return end_; }
  TimeNs begin() const { return begin_; }
  /// Where a point that the prediction brings to p in the frame of the end lies at share `alpha` of the interval:
  /// corrected_end() * p for a rigid correction.
  Pose end_at(double alpha) const;
  /// The same points in the frame of corrected_end(): hands the i-th of `count` to out(i, p); point_of(i) is where the
  /// prediction brings it, time_of(i) its time.
  template <class PointOf, class TimeOf, class Out>
  void to_end(std::size_t count, const PointOf& point_of, const TimeOf& time_of, const Out& out) const;
  const Pose& corrected_end() const { return corrected_end_; }
  /// Of the interval that has passed at t, in [0, 1].
  double share(TimeNs t) const;

  Pose pose(TimeNs t) const override;
  int dof() const override { return 6; }
  Pose moved(TimeNs t, const Eigen::VectorXd& xi) const override;
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  Pose predicted(TimeNs t) const;
  PointLanes in_end(const PointLanes& p, const PointLanes::Lane& alpha) const;

  Spread spread_;
  TimeNs begin_ = 0;
  std::vector<MotionSegment> segments_;
  NavState end_;
  Pose corrected_end_;
  Vec3 turn_ = Vec3::Zero(), move_ = Vec3::Zero();  ///< correction of the end, seen from there
};

template <class PointOf, class TimeOf, class Out>
void WindowTrajectory::to_end(std::size_t count, const PointOf& point_of, const TimeOf& time_of, const Out& out) const {
  if (spread_ == Spread::rigid) {
    for (std::size_t i = 0; i < count; ++i) out(i, point_of(i));
    return;
  }
  PointLanes points;
  PointLanes::Lane alpha{};
  for (std::size_t first = 0; first < count; first += PointLanes::kWidth) {
    const std::size_t n = std::min(PointLanes::kWidth, count - first);
    for (std::size_t l = 0; l < n; ++l) {
      points.set(l, point_of(first + l));
      alpha[l] = share(time_of(first + l));
    }
    const PointLanes placed = in_end(points, alpha);
    for (std::size_t l = 0; l < n; ++l) out(first + l, placed[l]);
  }
}

}  // namespace aslio
