#include "placement.hpp"

#include <limits>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::report {

namespace {

/// Throws DataError when the two have no time in common, or too little motion to align by.
Pose alignment_of(const Trajectory& estimate, const Trajectory& truth, const evaluation::Options& options) {
  const auto association = evaluation::associate_interpolated(estimate, truth, to_ns(options.max_reference_gap),
                                                              to_ns(options.max_estimate_gap));
  const auto weights = evaluation::time_weights(association.pairs, to_ns(options.max_estimate_gap));
  return evaluation::align(options.alignment, association.pairs, weights);
}

}  // namespace

std::optional<Placed> place(const FolderRun& run, const DataTruth& truth) {
  std::error_code ignored;
  const std::filesystem::path file = run.folder / "trajectory.tum";
  if (!std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  // A run that found no state leaves an empty one, and its reason says so.
  if (!run.good() && std::filesystem::file_size(file, ignored) == 0) return std::nullopt;
  Placed out;
  try {
    out.poses = io::read_tum(file);
    if (!truth.truth) return out;
    const auto options = experiment::measuring_options(*truth.truth, evaluation::Rule::interpolated);
    std::vector<StampedPose> compared = out.poses;
    for (StampedPose& pose : compared) pose.T.p += pose.T.R * truth.point;
    out.T_truth_run = alignment_of(Trajectory(compared), *truth.truth, options);
    out.aligned = true;
    const Vec3 unknown = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < out.poses.size(); ++i) {
      out.poses[i].T = out.T_truth_run * out.poses[i].T;
      const auto at = truth.truth->pose(compared[i].t, to_ns(options.max_reference_gap));
      out.errors.push_back(at ? Vec3(out.T_truth_run * compared[i].T.p - at->p) : unknown);
    }
  } catch (const DataError& error) {
    if (out.poses.empty()) out.unreadable = error.what();
  }
  return out;
}

}  // namespace aslio::report
