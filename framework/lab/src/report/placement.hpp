#pragma once
/// Where a run's trajectory lies in the world of the truth.

#include <optional>
#include <string>
#include <vector>

#include "aslio/report/run_series.hpp"

namespace aslio::report {

struct Placed {
  std::vector<StampedPose> poses;
  std::vector<Vec3> errors;  ///< position less truth [m], by pose; NaN where the truth tells none, empty without truth
  Pose T_truth_run;          ///< identity without truth
  bool aligned = false;
  std::string unreadable;  ///< why there are no poses although there is a file
};

/// Aligned as the ATE is. Nothing when the run has no trajectory.
std::optional<Placed> place(const FolderRun& run, const DataTruth& truth);

}  // namespace aslio::report
