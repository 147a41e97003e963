#pragma once
/// Runs a study on a cluster: one task of a job array per recording (docs/cluster.md).

#include <string>
#include <vector>

#include "aslio/experiment/study_run.hpp"

namespace aslio::experiment {

struct SlurmOptions {
  /// Program and arguments that work on one recording, less its name, which comes behind: `.. --recording`. Seen from
  /// the nodes.
  std::vector<std::string> command;
  std::vector<std::string> sbatch;  ///< further options of sbatch, as `--partition=long`
  int throttle = 100;               ///< tasks at once
  int attempts = 3;                 ///< of a task that is lost or leaves runs unfinished
  double poll_s = 10;               ///< between looks at the queue
};

/// Submits what is not finished, waits for it, submits again what was lost, writes the tables. Tasks of an earlier call
/// that are still in the queue are waited for. When stopped, the tasks go on, and the next call gathers what they have
/// made. Throws as run_study(), and ConfigError when Slurm is not there or refuses the options.
StudyResult run_study_on_slurm(const Study& study, const StudyOptions& options, const SlurmOptions& slurm,
                               StudyMonitor& monitor);

}  // namespace aslio::experiment
