#include <fmt/format.h>

#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "doubts.hpp"

namespace aslio::evaluation {

namespace {

void check(const Options& options) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0.0 && value < 1e9)) throw ConfigError(fmt::format("{} is {}, must be positive", name, value));
  };
  positive("max_reference_gap", options.max_reference_gap);
  positive("max_neighbour", 0.5 * options.max_neighbour);
  positive("max_estimate_gap", options.max_estimate_gap);
  positive("evo_max_difference", options.evo_max_difference);
  positive("grid_period", options.grid_period);
  positive("turn_rate", options.turn_rate);
  for (const double distance : options.distances) positive("distances", distance);
  for (const double duration : options.durations) positive("durations", duration);
}

/// Rotation of the estimate, aligned, as seen from the reference. eq. EVAL-9
Mat3 rotation_error(const PosePair& pair, const Mat3& R_alignment) {
  return pair.reference.R.transpose() * R_alignment * pair.estimate.R;
}

/// Pairs and their weights.
struct Sample {
  std::vector<PosePair> pairs;
  std::vector<double> weights;
  bool positions_only = false;
};

// eq. EVAL-9
PoseErrors absolute_errors(const Sample& sample, const Pose& alignment) {
  std::vector<double> translation, rotation;
  translation.reserve(sample.pairs.size());
  rotation.reserve(sample.pairs.size());
  for (const PosePair& pair : sample.pairs) {
    translation.push_back((alignment * pair.estimate.p - pair.reference.p).norm());
    if (!sample.positions_only) rotation.push_back(kDegPerRad * log_so3(rotation_error(pair, alignment.R)).norm());
  }
  return {weighted_statistics(translation, sample.weights),
          sample.positions_only ? Statistics{} : weighted_statistics(rotation, sample.weights)};
}

/// Weighted RMS angle [deg] of left^T * rotation_error(pair, R). eq. EVAL-9
double rotation_rmse(const Sample& sample, const Mat3& left, const Mat3& R) {
  double total = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < sample.pairs.size(); ++i) {
    total += sample.weights[i];
    squares += sample.weights[i] * log_so3(left.transpose() * rotation_error(sample.pairs[i], R)).squaredNorm();
  }
  return kDegPerRad * std::sqrt(squares / total);
}

/// The constant rotation between the worlds by orientations alone. eq. EVAL-6
Mat3 world_rotation(const Sample& sample) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < sample.pairs.size(); ++i) {
    sum += sample.weights[i] * sample.pairs[i].reference.R * sample.pairs[i].estimate.R.transpose();
  }
  return nearest_rotation(sum);
}

/// The constant rotation between the body frames after an alignment of the worlds. eq. EVAL-6
Mat3 body_rotation(const Sample& sample, const Mat3& R_alignment) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < sample.pairs.size(); ++i) {
    sum += sample.weights[i] * rotation_error(sample.pairs[i], R_alignment);
  }
  return nearest_rotation(sum);
}

void evaluate_turns(const Sample& sample, const Trajectory& reference, Evaluation& result) {
  Sample turns, straight;  // of a reference with orientations
  for (std::size_t i = 0; i < sample.pairs.size(); ++i) {
    Sample& part = turn_rate(reference, sample.pairs[i].t) > result.options.turn_rate ? turns : straight;
    part.pairs.push_back(sample.pairs[i]);
    part.weights.push_back(sample.weights[i]);
  }
  if (!turns.pairs.empty()) result.ate_turns = absolute_errors(turns, result.T_reference_estimate);
  if (!straight.pairs.empty()) result.ate_straight = absolute_errors(straight, result.T_reference_estimate);
}

/// Errors under an alignment of the sample's own, nothing where that is not determined.
std::optional<PoseErrors> aligned_errors(const Sample& sample, Alignment alignment, const char* what,
                                         Evaluation& result) {
  if (sample.pairs.empty()) {
    result.warnings.push_back(fmt::format("{}: no pose", what));
    return std::nullopt;
  }
  try {
    return absolute_errors(sample, align(alignment, sample.pairs, sample.weights));
  } catch (const DataError& error) {
    result.warnings.push_back(fmt::format("{}: {}", what, error.what()));
    return std::nullopt;
  }
}

EndToEnd end_to_end(const Trajectory& estimate, const std::vector<PosePair>& pairs) {
  EndToEnd result;
  result.distance = (estimate.samples().back().T.p - estimate.samples().front().T.p).norm();
  const PosePair& first = pairs.front();
  const PosePair& last = pairs.back();
  const Pose error =
      (first.reference.inverse() * last.reference).inverse() * (first.estimate.inverse() * last.estimate);
  result.error = error.p.norm();
  result.rotation_error = kDegPerRad * log_so3(error.R).norm();
  return result;
}

/// The way of this time is the shortest distance of the relative error: of the pairs of 10 Hz, six in ten are then
/// within its tolerance at least [s].
constexpr double kMinDistanceTime = 0.3;

/// Median speed of the reference where it moves, over steps of 0.1 s or, where its own are longer, over those [m/s].
double usual_speed(const Trajectory& reference) {
  constexpr TimeNs kStep = kSecond / 10;
  constexpr double kStanding = 0.1;  // [m/s]
  std::vector<double> speeds;
  const auto samples = reference.samples();
  for (std::size_t from = 0, to = 1; to < samples.size(); ++to) {
    const TimeNs step = samples[to].t - samples[from].t;
    if (step < kStep) continue;
    const double speed = (samples[to].T.p - samples[from].T.p).norm() / to_seconds(step);
    if (speed > kStanding) speeds.push_back(speed);
    from = to;
  }
  return weighted_statistics(speeds, std::vector<double>(speeds.size(), 1.0)).median;  // 0 of nothing
}

/// Distances by the reference alone, so that they are those of every estimate over it. eq. EVAL-11
std::vector<double> distances_for(const Trajectory& reference, double path) {
  const double least = kMinDistanceTime * usual_speed(reference);
  std::vector<double> out;
  for (const double distance : {1.0, 5.0, 10.0, 50.0, 100.0}) {
    if (distance >= least && distance <= 0.5 * path) out.push_back(distance);
  }
  return out;
}

void evaluate_relative(const Sample& sample, const Trajectory& reference, Evaluation& result) {
  std::vector<double> distances = result.options.distances;
  if (distances.empty()) distances = distances_for(reference, result.reference_path);
  for (const double distance : distances) {
    result.rpe.push_back(relative_error_over_distance(sample.pairs, sample.weights, distance));
  }
  for (const double duration : result.options.durations) {
    result.rpe.push_back(relative_error_over_time(sample.pairs, sample.weights, duration));
  }
}

void warn_of_shares(Evaluation& result) {
  if (result.matched_share < 0.9) {
    result.warnings.push_back(
        fmt::format("only {} of {} poses have a reference", result.matched, result.estimate_poses));
  }
  if (result.covered_share < 0.9) {
    result.warnings.push_back(
        fmt::format("the estimate covers {:.0f} % of the reference's duration: its errors are not "
                    "comparable with those of a complete run",
                    100.0 * result.covered_share));
  }
}

/// Errors that are not small against the spread of the positions turn the alignment, which then hides part of them.
void warn_of_alignment(const Sample& sample, Evaluation& result) {
  constexpr double kTimes = 5.0;
  const Alignment alignment = result.options.alignment;
  const double spread = determining_spread(alignment, sample.pairs, sample.weights);
  const double error = result.ate.translation.rmse;
  if (spread >= kTimes * error) return;
  result.warnings.push_back(
      fmt::format("the alignment is poorly determined: the positions spread by {:.3f} m {}, less than {:.0f} times "
                  "their error of {:.3f} m. So it hides part of the error, and its rotation is not reliable. Use a "
                  "longer trajectory, or the relative errors, which need no alignment",
                  spread, alignment == Alignment::se3 ? "across their main direction" : "horizontally", kTimes, error));
}

Association associate(const Trajectory& estimate, const Trajectory& reference, const Options& options) {
  const TimeNs estimate_gap = to_ns(options.max_estimate_gap);
  switch (options.rule) {
    case Rule::evo:
      return associate_nearest(estimate, reference, to_ns(options.evo_max_difference), estimate_gap);
    case Rule::at_reference:
      return associate_at_reference(estimate, reference, estimate_gap);
    case Rule::interpolated:
      break;
  }
  return associate_interpolated(estimate, reference, to_ns(options.max_reference_gap), estimate_gap,
                                to_ns(options.max_neighbour));
}

/// Of what needs the orientation of the reference.
void evaluate_rotations(const Sample& sample, const Trajectory& estimate, const Trajectory& reference,
                        Evaluation& result) {
  result.end_to_end = end_to_end(estimate, sample.pairs);
  if (sample.positions_only) {
    result.end_to_end.error = result.end_to_end.rotation_error = 0;
    return;
  }
  result.ate_deg_rotation_aligned = rotation_rmse(sample, Mat3::Identity(), world_rotation(sample));
  const Mat3& R = result.T_reference_estimate.R;
  result.ate_deg_body_offset_removed = rotation_rmse(sample, body_rotation(sample, R), R);
  evaluate_turns(sample, reference, result);
  evaluate_relative(sample, reference, result);
}

Trajectory shifted(const Trajectory& trajectory, const Vec3& by) {
  std::vector<StampedPose> poses(trajectory.samples().begin(), trajectory.samples().end());
  for (StampedPose& pose : poses) pose.T.p += by;
  return Trajectory(std::move(poses));
}

/// What was taken off the reference shows in the transform alone.
void restore_origin(Evaluation& result) {
  if (result.options.alignment != Alignment::none) result.T_reference_estimate.p += result.options.reference_origin;
}

}  // namespace

double turn_rate(const Trajectory& reference, TimeNs t) {
  constexpr TimeNs half = kSecond / 20;
  const TimeNs begin = std::max(t - half, reference.begin_time());
  const TimeNs end = std::min(t + half, reference.end_time());
  const auto from = reference.pose(begin);
  const auto to = reference.pose(end);
  if (!from || !to || end <= begin) return 0.0;
  return log_so3(from->R.transpose() * to->R).norm() / to_seconds(end - begin);
}

Evaluation evaluate(const Trajectory& given, const Trajectory& reference, const Options& options) {
  check(options);
  const bool moves = options.alignment == Alignment::none && !options.reference_origin.isZero(0);
  const Trajectory moved = moves ? shifted(given, -options.reference_origin) : Trajectory();
  const Trajectory& estimate = moves ? moved : given;
  const TimeNs reference_gap = to_ns(options.max_reference_gap);
  const TimeNs estimate_gap = to_ns(options.max_estimate_gap);
  Association association = associate(estimate, reference, options);

  Evaluation result;
  result.options = options;
  result.estimate_poses = association.estimate_poses;
  result.matched = association.matched();
  result.unmatched = association.unmatched();
  result.matched_share = static_cast<double>(result.matched) / static_cast<double>(result.estimate_poses);
  result.covered_share = association.covered;
  result.estimate_path = estimate.path_length();
  result.reference_path = reference.path_length();
  warn_of_shares(result);
  warn_of_reference(estimate, reference, result);

  Sample sample{std::move(association.pairs), {}, options.positions_only};
  const bool weighted = options.weight_by_time && options.rule != Rule::evo;
  sample.weights = weighted ? time_weights(sample.pairs, estimate_gap) : std::vector<double>(sample.pairs.size(), 1.0);
  result.T_reference_estimate = align(options.alignment, sample.pairs, sample.weights);
  result.ate = absolute_errors(sample, result.T_reference_estimate);
  warn_of_alignment(sample, result);
  result.ate_yaw = aligned_errors(sample, Alignment::yaw, "aligned by yaw", result);
  if (options.rule != Rule::at_reference) {
    Sample grid{associate_on_grid(estimate, reference, to_ns(options.grid_period), reference_gap, estimate_gap),
                {},
                options.positions_only};
    grid.weights.assign(grid.pairs.size(), 1.0);
    result.ate_grid = aligned_errors(grid, options.alignment, "on the common grid", result);
  }
  evaluate_rotations(sample, estimate, reference, result);
  if (options.scoring != Scoring::none) {
    result.score = score_of(options.scoring, sample.pairs, result.T_reference_estimate, reference.size());
  }
  warn_of_time_offset(estimate, reference, result);
  restore_origin(result);
  return result;
}

}  // namespace aslio::evaluation
