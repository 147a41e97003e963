#pragma once
/// Files that runs leave for other runs of the study: `{run:NAME}/updates.csv`.

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_results.hpp"

namespace aslio::experiment {

class UsedFiles {
 public:
  explicit UsedFiles(const Study& study);

  /// read_outcome() under the run's key; nothing, too, where a file is gone that another run of the study reads: that
  /// run could not be made, however often it is tried.
  std::optional<StudyOutcome> outcome(const StudyRun& run, const std::filesystem::path& folder) const;

 private:
  std::vector<std::vector<std::string_view>> files_;  ///< by method that leaves them
};

}  // namespace aslio::experiment
