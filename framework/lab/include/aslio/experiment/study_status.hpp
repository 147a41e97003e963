#pragma once
/// How far a study is, told from its folder alone: while it runs, afterwards, or when it was killed.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// Writes plan.csv: all runs of the study, whichever of them a call is to make. `keep`: not where the same is there for
/// another number of jobs. Throws DataError.
void write_plan(const Study& study, const std::vector<StudyRun>& runs, int jobs, const std::filesystem::path& output,
                bool keep = false);

/// Throws ConfigError when the folder holds another study, by plan.csv. What to say where it was made with another
/// --scale; nothing otherwise.
std::optional<std::string> require_same_study(const Study& study, const std::filesystem::path& output);

/// Runs by their state.
struct RunCounts {
  std::size_t good = 0, failed = 0, running = 0, waiting = 0;
  std::size_t all() const { return good + failed + running + waiting; }
};

struct StudyStatus {
  std::vector<std::string> sequences, methods;
  std::vector<std::vector<RunCounts>> cells;  ///< by sequence and method
  RunCounts total;
  std::vector<std::string> running;   ///< "DATA/RUN, for 12 s"
  std::vector<std::string> failures;  ///< "DATA/RUN: status (reason)"
  bool at_work = false;               ///< a process holds the folder
  std::optional<double> left_s;       ///< by the times of finished runs of the same methods; simulations left out
};

/// Throws ConfigError where no study has been.
StudyStatus read_status(const std::filesystem::path& output);
/// A table of sequences and methods, what runs, what failed and how long the rest takes.
std::string to_text(const StudyStatus& status);

}  // namespace aslio::experiment
