#pragma once
/// What is said to Slurm, and what it answers.

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "aslio/experiment/study_slurm.hpp"

namespace aslio::experiment {

/// A job array: one task per name.
struct SlurmArray {
  std::filesystem::path folder;  ///< tasks.txt, job.sh, job_id, log-N.txt, done/N
  std::string job;
  std::vector<std::string> names;

  std::string task(std::size_t index) const;  ///< "123_4"
  /// Exit code of a task that came to its end.
  std::optional<int> ended(std::size_t index) const;
};

class SlurmQueue {
 public:
  /// `folder`: inside the output of the study; created.
  SlurmQueue(const std::filesystem::path& folder, const SlurmOptions& options);

  /// Arrays of earlier calls.
  std::vector<SlurmArray> earlier() const;
  /// Nothing when the controller cannot be reached at the moment. Throws ConfigError when Slurm is not there or
  /// refuses.
  std::optional<SlurmArray> submit(const std::vector<std::string>& names, int jobs);
  /// Tasks of this study that wait or run, as SlurmArray::task(). Nothing when the controller cannot be reached.
  std::optional<std::set<std::string>> alive() const;

 private:
  std::string name() const;

  std::filesystem::path folder_;
  const SlurmOptions& options_;
};

}  // namespace aslio::experiment
