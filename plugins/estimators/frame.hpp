#pragma once
/// The fresh points of one window on their way from raw to world: sampled, de-skewed to the end of the window, sampled
/// again, placed. Shared by estimators that register a whole window. All storage is reused.

#include <array>
#include <span>
#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

/// T_W_I over a fresh interval: the predicted segments, moved rigidly with the correction of the end pose.
class RigidTrajectory final : public TrajectoryModel {
 public:
  void reserve(std::size_t segments) { segments_.reserve(segments); }
  void clear(const NavState& start);
  void append(const MotionSegment& segment, const NavState& end);
  /// The end pose after the update; everything before it moves along rigidly.
  void correct(const Pose& end) { corrected_end_ = end; }

  std::span<const MotionSegment> segments() const { return segments_; }
  const NavState& predicted_end() const { return end_; }

  Pose pose(TimeNs t) const override;
  int dof() const override { return 6; }
  void jacobian(TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  Pose predicted(TimeNs t) const;

  std::vector<MotionSegment> segments_;
  NavState end_;
  Pose corrected_end_;
};

class Frame {
 public:
  explicit Frame(const SensorModel& sensor) : T_imu_lidar_(sensor.T_imu_lidar) {}

  /// Raw phase of the chain over the fresh points; keeps those some tap still wants.
  void sample_raw(std::span<const TimedPoint> fresh, SamplerChain& samplers);
  /// p_I at the end of the window for every kept point (docs/equations.md DSK-1).
  void deskew(const RigidTrajectory& trajectory);
  /// Body phase of the chain, then the lists per tap.
  void sample_body(SamplerChain& samplers);
  /// World points of every tap for the end pose T_W_I.
  void place(const Pose& end);

  /// Body points and ranges of the match tap.
  std::span<const Vec3> match_body() const { return match_body_; }
  std::span<const float> match_range() const { return match_range_; }
  std::span<const WorldPoint> world(Tap tap) const { return world_[slot(tap)]; }

 private:
  static constexpr std::size_t slot(Tap tap) { return tap == Tap::overlap ? 0 : tap == Tap::map ? 1 : 2; }

  void reserve(std::size_t points);

  Pose T_imu_lidar_;
  std::vector<TimedPoint> raw_;
  std::vector<std::uint32_t> index_;  ///< into the window's fresh points
  std::vector<TapMask> taps_;
  std::vector<Eigen::Vector3f> body_;
  std::vector<Vec3> match_body_;
  std::vector<float> match_range_;
  std::array<std::vector<WorldPoint>, 3> world_;
};

}  // namespace aslio::plugins
