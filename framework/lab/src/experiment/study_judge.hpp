#pragma once
/// What the end of a child means for its run.

#include <filesystem>
#include <string>

#include "aslio/experiment/study_results.hpp"
#include "study_process.hpp"

namespace aslio::experiment {

/// In words: the signal, or the first complaint in its log.
std::string exit_text(const ChildEnd& end, const std::filesystem::path& log);

/// Outcome of a run: a limit, a signal, or what its summary says where that agrees with its exit code.
StudyOutcome judge_run(const ChildEnd& end, const std::filesystem::path& folder, const std::filesystem::path& log,
                       const StudyConfig& config);

}  // namespace aslio::experiment
