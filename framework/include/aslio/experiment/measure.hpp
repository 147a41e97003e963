#pragma once

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

}  // namespace aslio::experiment
