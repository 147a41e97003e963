#include "study_uses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace aslio::experiment {

namespace {

/// What every run leaves that ended by itself. A name that no run writes would have its run made again for nothing.
constexpr std::array<std::string_view, 6> kLeft = {"trajectory.tum", "trajectory_lidar.tum", "updates.csv",
                                                   "timings.csv",    "resolved.yaml",        "manifest.json"};

/// One that failed, crashed or met a limit may never have had them, and would be the same again.
bool has_left_files(std::string_view status) {
  return status == "ok" || status == "degraded" || status == "diverged" || status == "truncated";
}

}  // namespace

UsedFiles::UsedFiles(const Study& study) : files_(study.methods.size()) {
  for (const StudyMethod& method : study.methods) {
    for (const auto& [name, used] : method.uses) {
      for (const std::string_view file : kLeft) {
        const std::string text = fmt::format("{{run:{}}}/{}", name, file);
        const bool named = std::any_of(method.set.begin(), method.set.end(), [&](const std::string& assignment) {
          return assignment.find(text) != std::string::npos;
        });
        auto& files = files_[used];
        if (named && std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
      }
    }
  }
}

std::optional<StudyOutcome> UsedFiles::outcome(const StudyRun& run, const std::filesystem::path& folder) const {
  auto outcome = read_outcome(folder, run.key);
  if (!outcome || !has_left_files(outcome->status)) return outcome;
  for (const std::string_view file : files_[run.method]) {
    std::error_code ignored;
    if (!std::filesystem::exists(folder / file, ignored)) return std::nullopt;
  }
  return outcome;
}

}  // namespace aslio::experiment
