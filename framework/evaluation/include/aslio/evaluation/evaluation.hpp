#pragma once
/// How far a trajectory is from the truth.

#include <optional>
#include <string>
#include <vector>

#include "aslio/evaluation/alignment.hpp"
#include "aslio/evaluation/statistics.hpp"
#include "aslio/evaluation/time_offset.hpp"

namespace aslio::evaluation {

/// interpolated: the reference at the estimate's stamps, errors weighted by time.
/// evo: nearest stamps within 0.01 s, every pair counts the same, as evo_ape and evo_rpe do.
/// at_reference: the estimate at the reference's stamps, for a sparse reference.
enum class Rule { interpolated, evo, at_reference };

/// Points for each pose of the reference by its position error, none for one that is not matched. eq. EVAL-14
enum class Scoring { none, hilti_2022, hilti_2023 };

struct Options {
  Rule rule = Rule::interpolated;
  Alignment alignment = Alignment::se3;
  bool weight_by_time = true;        ///< of the rule interpolated; false: every pair counts the same
  double max_reference_gap = 0.1;    ///< [s] no interpolation of the reference across more
  double max_neighbour = 1e9;        ///< [s] of a stamp, to either sample of the reference beside it
  double max_estimate_gap = 1.0;     ///< [s] longer gaps are not covered, and a pose never weighs for more
  double evo_max_difference = 0.01;  ///< [s]
  double grid_period = 0.1;          ///< [s]
  double turn_rate = 0.5;            ///< [rad/s] of the reference: above is a turn, below is straight
  /// [m] distances of the relative error; empty: those of 1, 5, 10, 50, 100 m from the way of 0.3 s at the reference's
  /// usual speed, below which an estimate of 10 Hz may have no pairs, up to half its path.
  std::vector<double> distances;
  std::vector<double> durations = {1.0};  ///< [s]
  /// The reference tells positions of a point alone, which are those of the estimate: no figure of rotation, and none
  /// of what needs the orientation of the reference (relative errors, turns).
  bool positions_only = false;
  Scoring scoring = Scoring::none;
  Vec3 reference_origin = Vec3::Zero();  ///< [m] what was taken off the positions of a reference far from its origin
};

struct PoseErrors {
  Statistics translation;  ///< [m]
  Statistics rotation;     ///< [deg]; n = 0 where the reference tells none
};

enum class DeltaUnit { metres, seconds };

/// Errors of relative poses over one distance or duration.
struct RelativeError {
  double delta = 0;
  DeltaUnit unit = DeltaUnit::metres;
  std::size_t pairs = 0;
  double translation_rmse = 0;  ///< [m]
  double rotation_rmse = 0;     ///< [deg]
};

struct EndToEnd {
  double distance = 0;  ///< [m] from the estimate's first position to its last: the error on a closed loop
  double error = 0;     ///< [m] of the relative pose from the first to the last matched pose, against the reference
  double rotation_error = 0;  ///< [deg] of the same
};

struct Evaluation {
  Options options;
  std::size_t estimate_poses = 0, matched = 0, unmatched = 0;
  double matched_share = 0;   ///< of the estimate's poses
  double covered_share = 0;   ///< of the reference's duration
  Pose T_reference_estimate;  ///< the alignment
  PoseErrors ate;
  /// Rotation RMSE [deg] with the constant rotation between the worlds estimated from the orientations. On a small loop
  /// the positions determine that rotation poorly (error of centimetres over metres), and it enters ate.rotation.
  double ate_deg_rotation_aligned = 0;
  /// Rotation RMSE [deg] after the alignment by positions, a constant rotation of the body frame removed.
  double ate_deg_body_offset_removed = 0;
  std::optional<PoseErrors> ate_yaw;       ///< aligned by yaw and position only: shows tilt. Unset when degenerate
  std::optional<PoseErrors> ate_grid;      ///< both on the common grid, aligned there
  std::optional<PoseErrors> ate_turns;     ///< poses during turns of the reference, alignment of ate
  std::optional<PoseErrors> ate_straight;  ///< the others
  std::vector<RelativeError> rpe;          ///< without alignment, pairs chosen along the reference
  EndToEnd end_to_end;
  double estimate_path = 0, reference_path = 0;  ///< [m]
  std::optional<double> score;                   ///< 0 to 100, of Options::scoring
  std::optional<TimeOffset> time_offset;         ///< that would lower the error; nothing was shifted
  std::vector<std::string> notes;                ///< what was decided of the reference
  std::vector<std::string> warnings;             ///< why the figures may not mean what they seem to
};

/// Throws DataError when the two have no time in common (with both ranges and the likely cause), when an alignment is
/// not determined, or when a trajectory is empty; ConfigError when an option is out of range.
Evaluation evaluate(const Trajectory& estimate, const Trajectory& reference, const Options& options = {});

/// Angular rate of the reference at `t` [rad/s], over 0.1 s around it (less at the ends). eq. EVAL-10
double turn_rate(const Trajectory& reference, TimeNs t);

/// Relative errors over `delta` metres of the reference's path, or seconds. `weights` as for align(). eq. EVAL-11
RelativeError relative_error_over_distance(std::span<const PosePair> pairs, std::span<const double> weights,
                                           double delta);
RelativeError relative_error_over_time(std::span<const PosePair> pairs, std::span<const double> weights, double delta);

}  // namespace aslio::evaluation
