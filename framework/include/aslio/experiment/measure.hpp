#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "aslio/evaluation/evaluation.hpp"

namespace aslio::experiment {

/// How runs and `aslio evaluate` measure: the defaults, and interpolation across up to 2.5 usual steps of the
/// reference, so that one of 10 Hz serves as well as one of 200 Hz.
evaluation::Options measuring_options(const Trajectory& reference, evaluation::Rule rule);

/// Translation RMSE [m] over the shortest distance of the relative errors, the headline figure `rpe`. Nothing when the
/// reference's path is too short for any.
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
std::optional<std::pair<TimeNs, std::string>> find_divergence(const evaluation::Evaluation& evaluation,
                                                              std::span<const StampedPose> poses,
                                                              const Trajectory& reference);

}  // namespace aslio::experiment
