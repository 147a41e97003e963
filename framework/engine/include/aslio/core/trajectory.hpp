#pragma once

#include <optional>
#include <span>
#include <vector>

#include "aslio/core/types.hpp"

namespace aslio {

/// Poses in strictly increasing time; pose(t) interpolates on SO(3) x R^3.
class Trajectory {
 public:
  Trajectory() = default;
  /// Throws DataError when times do not strictly increase or a pose is not finite.
  explicit Trajectory(std::vector<StampedPose> poses);

  /// Throws DataError when `pose.t` is not later than the last or the pose is not finite.
  void append(const StampedPose& pose);

  /// Interpolated pose; nothing outside [begin, end].
  std::optional<Pose> pose(TimeNs t) const;
  /// As pose(), but nothing either when `t` lies between two samples that are more than `max_gap` apart.
  std::optional<Pose> pose(TimeNs t, TimeNs max_gap) const;

  bool empty() const { return poses_.empty(); }
  std::size_t size() const { return poses_.size(); }
  std::span<const StampedPose> samples() const { return poses_; }
  TimeNs begin_time() const { return poses_.front().t; }
  TimeNs end_time() const { return poses_.back().t; }
  /// Sum of the distances between consecutive positions [m].
  double path_length() const;

 private:
  std::vector<StampedPose> poses_;
};

}  // namespace aslio
