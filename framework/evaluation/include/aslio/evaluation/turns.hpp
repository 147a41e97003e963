#pragma once
/// How far a body turns between two moments, by a gyro or by poses.

#include <optional>
#include <span>
#include <vector>

#include "aslio/core/trajectory.hpp"

namespace aslio::evaluation {

/// Poses of one body that were measured one after the other without a break, in any world.
struct MotionStretch {
  std::vector<StampedPose> poses;  ///< in strictly increasing time
  /// Each pose is the mean of the motion over this time around its stamp: points of a window give one [ns].
  TimeNs window = 0;
};

/// Something that measures how a body turns.
class TurnSource {
 public:
  virtual ~TurnSource() = default;
  /// Rotation vector from the body at `begin` to the body at `end`, in its axes [rad]; at most pi. `end` may be
  /// earlier. Nothing where the data do not cover the time.
  virtual std::optional<Vec3> turn(TimeNs begin, TimeNs end) const = 0;
};

/// The rate of a gyro, integrated. Biases and errors of scale stay in. eq. FRM-1
class GyroTurns final : public TurnSource {
 public:
  /// `imu`: in order of time; samples at the time of their predecessor are left out. No turn reaches over a time of
  /// more than `max_gap` between two samples.
  GyroTurns(std::span<const ImuSample> imu, TimeNs max_gap);
  std::optional<Vec3> turn(TimeNs begin, TimeNs end) const override;

 private:
  struct Knot {
    TimeNs t;
    Mat3 R;     ///< since the first sample
    Vec3 rate;  ///< mean up to the next one [rad/s]
    int gaps;   ///< before it
  };
  const Knot* knot_before(TimeNs t) const;

  std::vector<Knot> knots_;
};

/// Poses, interpolated (eq. LIE-9) between samples at most `max_gap` apart. The trajectory must outlive it.
class PathTurns final : public TurnSource {
 public:
  PathTurns(const Trajectory& path, TimeNs max_gap) : path_(path), max_gap_(max_gap) {}
  std::optional<Vec3> turn(TimeNs begin, TimeNs end) const override;

 private:
  const Trajectory& path_;
  TimeNs max_gap_;
};

/// The turn between the means over `window` around both moments: what poses of windows show. eq. FRM-1
std::optional<Vec3> mean_turn(const TurnSource& source, TimeNs begin, TimeNs end, TimeNs window);

/// Offsets within a window at which a mean over it is taken [ns].
std::vector<TimeNs> window_offsets(TimeNs window);

}  // namespace aslio::evaluation
