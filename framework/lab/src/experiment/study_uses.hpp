#pragma once
/// Files that runs leave for other runs of the study: `{run:NAME}/updates.csv`.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/experiment/study_run.hpp"

namespace aslio::experiment {

class UsedFiles {
 public:
  explicit UsedFiles(const Study& study);

  /// read_outcome() under the run's key; nothing, too, where a file is gone or empty that another run of the study
  /// reads: that run could not be made, however often it is tried.
  std::optional<StudyOutcome> outcome(const StudyRun& run, const std::filesystem::path& folder) const;

  /// Rows of the runs that are finished. Only of those selected is asked that the files for others are there, too: they
  /// can be made again, and the others have their figures all the same. `recording`: of this one alone, unless empty.
  std::vector<std::optional<StudyRow>> rows(const Study& study, const std::vector<StudyRun>& runs,
                                            const std::filesystem::path& output, const std::string& recording,
                                            const std::vector<bool>& selected) const;

 private:
  std::vector<std::vector<std::string_view>> files_;  ///< by method that leaves them
};

/// The outcome of a run that is not made because another whose files it reads was ended from outside: a part of a
/// schedule would be taken for all of it.
std::optional<StudyOutcome> without_whole_files(const StudyResult& result, const Study& study, std::size_t run);

}  // namespace aslio::experiment
