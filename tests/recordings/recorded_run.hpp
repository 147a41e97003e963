#pragma once
/// Runs of the shipped pipelines over the recordings, as `aslio run` does them.

#include <filesystem>
#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"

namespace aslio::test {

/// CPU time of an update, from timings.csv [s].
struct UpdateCost {
  double all = 0, overlap = 0;
};

struct RecordedRun {
  experiment::Summary summary;
  std::string trajectory_sha256;     ///< of trajectory.tum
  std::vector<TimeNs> update_times;  ///< ends of the windows, from updates.csv
  std::vector<UpdateCost> costs;     ///< of the same updates
  Trajectory lidar;                  ///< of the LiDAR, from trajectory_lidar.tum
  double ate_m() const { return summary.evaluation.value().ate.translation.rmse; }
  double cpu_per_s() const { return summary.cpu_s / summary.data_s; }
};

/// `pipeline` names a file of configs/pipelines; `overrides` as `aslio run --set`. Throws what experiment::run() and
/// unpacked_*() throw.
/// `order_seed`: another offset of the first window, another phase of the strides.
RecordedRun run_on_avia(const std::string& pipeline, int threads = 1, const std::vector<std::string>& overrides = {},
                        std::uint64_t order_seed = 0);
/// Evaluated against a published system, for OXTS drifts by metres here.
RecordedRun run_on_kitti(const std::string& pipeline, int threads = 1,
                         const std::string& reference = "reference/kitti_0005/fast_lio2.tum");
/// The first 60 scans of drive 0013, a car at 11 m/s from the first sample on, against OXTS (good to 0.15 to 0.3 m).
RecordedRun run_on_moving_kitti(const std::string& pipeline, double start_s = 0);

/// A run of the first 5 s with two threads has the bits of one with a single thread. Where threads make a difference,
/// every update carries it on: a part shows it as well as the whole.
bool same_bits_on_avia(const std::string& pipeline);
bool same_bits_on_kitti(const std::string& pipeline);

}  // namespace aslio::test
