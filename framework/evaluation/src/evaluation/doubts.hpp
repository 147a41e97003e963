#pragma once
/// What is to be said of a reference and its association, besides the figures.

#include "aslio/evaluation/evaluation.hpp"

namespace aslio::evaluation {

/// Gaps of the reference that leave poses out, and what its rate may cost where it is interpolated.
void warn_of_reference(const Trajectory& estimate, const Trajectory& reference, Evaluation& result);

/// Fills Evaluation::time_offset and tells of it.
void warn_of_time_offset(const Trajectory& estimate, const Trajectory& reference, Evaluation& result);

/// 0 to 100: points of the pairs over the most that all poses of the reference could have. eq. EVAL-14
double score_of(Scoring scoring, std::span<const PosePair> pairs, const Pose& alignment, std::size_t reference_poses);

}  // namespace aslio::evaluation
