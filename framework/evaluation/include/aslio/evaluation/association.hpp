#pragma once
/// Which reference pose belongs to which estimated pose.

#include <cstddef>
#include <vector>

#include "aslio/core/trajectory.hpp"

namespace aslio::evaluation {

/// An estimated and a true pose of the same moment; each in the world of its own trajectory.
struct PosePair {
  TimeNs t = 0;  ///< of the estimate
  Pose estimate;
  Pose reference;
};

struct Association {
  std::vector<PosePair> pairs;     ///< in order of time
  std::size_t estimate_poses = 0;  ///< of them, pairs.size() are matched (evo rule: of the shorter trajectory)
  double covered = 0;              ///< share of the reference's duration that the estimate spans without a gap, 0 to 1

  std::size_t matched() const { return pairs.size(); }
  std::size_t unmatched() const { return estimate_poses - pairs.size(); }
};

/// The reference interpolated (SLERP, linear position) at the estimate's stamps; a stamp between two reference samples
/// more than `max_reference_gap` apart, or with either of them farther than `max_neighbour`, stays unmatched. Stretches
/// of the estimate without a pose for more than `max_estimate_gap` are not covered. Throws DataError that names both
/// time ranges when nothing matches. eq. EVAL-1
Association associate_interpolated(const Trajectory& estimate, const Trajectory& reference, TimeNs max_reference_gap,
                                   TimeNs max_estimate_gap, TimeNs max_neighbour = kTimeMax);

/// The estimate interpolated at the stamps of the reference, across gaps of at most `max_estimate_gap`: for a sparse
/// reference. Counts are of the poses of the reference. Same errors. eq. EVAL-12
Association associate_at_reference(const Trajectory& estimate, const Trajectory& reference, TimeNs max_estimate_gap);

/// The rule of evo: for each pose of the shorter trajectory (the estimate when equal) the pose of the other nearest in
/// time, if within `max_difference`; a pose may serve twice. Same errors. eq. EVAL-2
Association associate_nearest(const Trajectory& estimate, const Trajectory& reference, TimeNs max_difference,
                              TimeNs max_estimate_gap);

/// Both interpolated at the multiples of `period`: the same moments for every estimate of one recording. Empty when no
/// multiple lies in both. eq. EVAL-3
std::vector<PosePair> associate_on_grid(const Trajectory& estimate, const Trajectory& reference, TimeNs period,
                                        TimeNs max_reference_gap, TimeNs max_estimate_gap);

}  // namespace aslio::evaluation
