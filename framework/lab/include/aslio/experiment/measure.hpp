#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "aslio/evaluation/evaluation.hpp"

namespace aslio::experiment {

/// How runs and `aslio evaluate` measure: the defaults, and interpolation across up to 2.5 usual steps of the
/// reference, so that one of 10 Hz serves as well as one of 200 Hz.
evaluation::Options measuring_options(const Trajectory& reference, evaluation::Rule rule);

/// Translation RMSE [m] over the shortest distance of the relative errors, the headline figure `rpe`. Nothing when the
/// reference's path is too short for any, or the estimate's poses are too far apart for that one.
struct HeadlineRpe {
  double rmse_m = 0;
  double distance_m = 0;
};
std::optional<HeadlineRpe> headline_rpe(const evaluation::Evaluation& evaluation);

/// A position error beyond both of these is a divergence: a share of the path travelled so far, and metres.
inline constexpr double kDivergedShare = 0.05;
inline constexpr double kDivergedError = 2.0;

/// The first moment at which `poses` have diverged from the reference, and why. Errors at a moment are those after a
/// rigid alignment of the positions up to that moment. The path is that of the reference. Poses that the evaluation
/// could not match are passed over.
std::optional<std::pair<TimeNs, std::string>> find_divergence(std::span<const StampedPose> poses,
                                                              const Trajectory& reference);

/// Where a run is told to have failed as a whole, not midway: before this share of the way.
inline constexpr double kEarlyShare = 0.1;
/// Without an accepted update for longer than this, a run has failed [ns].
inline constexpr TimeNs kMaxSilence = kSecond;

/// The share of the reference's path after which a run has failed, by the marks of a results table: its position is
/// off by more than both limits above, with the estimate laid on the reference over its first second (so that a late
/// failure is not shared out over the way before it), or `other` has come, whichever is first. Nothing when it has not
/// failed. `other`: of a failure of another kind.
/// `positions_only`: of a reference without orientations, on which a second does not lay an estimate; then it has
/// failed where find_divergence() says.
std::optional<double> failed_after(std::span<const StampedPose> poses, const Trajectory& reference,
                                   std::optional<TimeNs> other, bool positions_only = false);

/// Tells during a run that it is lost for good: neither what find_divergence() nor what failed_after() say of its poses
/// so far will change. Costs a look into the reference per pose until the position is off; from then on, and until
/// find_divergence() agrees, one of its searches per second of data.
class DivergenceWatch {
 public:
  /// `reference` must outlive it. `positions_only`: as of failed_after(); it then searches once per second of data.
  explicit DivergenceWatch(const Trajectory& reference, bool positions_only = false);
  /// `poses`: all so far. What find_divergence() says, once both have come and kMaxSilence has passed: by then a
  /// silence that began before, and is what failed first, is known to be one.
  std::optional<std::pair<TimeNs, std::string>> look(std::span<const StampedPose> poses);

 private:
  bool off_limits(const StampedPose& estimate) const;

  const Trajectory& reference_;
  bool positions_only_ = false;
  TimeNs max_gap_ = 0;
  std::vector<double> path_;      ///< of the reference up to each of its samples [m]
  std::optional<Pose> laid_;      ///< of the estimate on the reference
  std::size_t looked_ = 0;        ///< poses at the last look
  std::optional<TimeNs> first_;   ///< pose that the reference covers
  std::size_t seen_ = 0;          ///< poses that have been looked at, for first_, then for failed_
  std::optional<TimeNs> failed_;  ///< in the sense of failed_after()
  TimeNs next_ = kTimeMin;        ///< of the next search for a divergence
};

}  // namespace aslio::experiment
