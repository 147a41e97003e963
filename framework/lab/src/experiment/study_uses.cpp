#include "study_uses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "aslio/experiment/study_expectation.hpp"
#include "study_store.hpp"

namespace aslio::experiment {

namespace {

/// What every run leaves that ended by itself. A name that no run writes would have its run made again for nothing.
constexpr std::array<std::string_view, 6> kLeft = {"trajectory.tum", "trajectory_lidar.tum", "updates.csv",
                                                   "timings.csv",    "resolved.yaml",        "manifest.json"};

/// One that failed, crashed or met a limit may never have had them, and would be the same again.
bool has_left_files(std::string_view status) {
  return status == "ok" || status == "degraded" || status == "diverged" || status == "truncated";
}

/// One that was ended from outside leaves well-formed files of a part of the recording.
bool is_cut_off(std::string_view status) { return status == "timeout" || status == "memory" || status == "crashed"; }

/// Is this what a run leaves? A trajectory has no header, and that of a run without an update no line.
bool is_left(const std::filesystem::path& file) {
  std::error_code ignored;
  return has_content(file) || (file.extension() == ".tum" && std::filesystem::is_regular_file(file, ignored));
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
    if (!is_left(folder / file)) return std::nullopt;
  }
  return outcome;
}

std::vector<std::optional<StudyRow>> UsedFiles::rows(const Study& study, const std::vector<StudyRun>& runs,
                                                     const std::filesystem::path& output, const std::string& recording,
                                                     const std::vector<bool>& selected) const {
  std::vector<std::optional<StudyRow>> rows(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string& data = study.data[runs[i].data].name;
    if (!recording.empty() && data != recording) continue;
    const std::filesystem::path folder = output / "runs" / data / runs[i].folder;
    const auto found = selected[i] ? outcome(runs[i], folder) : read_outcome(folder, runs[i].key);
    if (found) rows[i] = read_row(folder, *found);
  }
  return rows;
}

bool stands(const StudyOutcome& outcome, const Study& study, const StudyOptions& options) {
  const std::array<std::string_view, 4> again = {"failed", "crashed", "timeout", "memory"};
  if (options.retry && std::find(again.begin(), again.end(), outcome.status) != again.end()) return false;
  return outcome.stands(study.config);
}

std::vector<bool> standing_runs(const Study& study, const StudyOptions& options, const std::vector<StudyRun>& runs,
                                const std::vector<std::optional<StudyRow>>& rows) {
  std::vector<bool> out(runs.size(), false);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!rows[i] || !stands(rows[i]->outcome, study, options)) continue;
    // Its key does not tell: that of what it has read is the same for a run that was cut off and for a whole one.
    out[i] = std::all_of(runs[i].uses.begin(), runs[i].uses.end(), [&](std::size_t used) {
      return !rows[used] || (out[used] && !is_cut_off(rows[used]->outcome.status));
    });
  }
  return out;
}

std::optional<StudyOutcome> without_whole_files(const StudyResult& result, const Study& study, std::size_t run) {
  for (const std::size_t used : result.runs[run].uses) {
    const auto& row = result.rows[used];
    if (!row || !is_cut_off(row->outcome.status)) continue;
    return StudyOutcome{.status = "failed",
                        .reason = fmt::format("it reads files of {}, which was cut off ({}: {})",
                                              study.methods[result.runs[used].method].name, row->outcome.status,
                                              one_line(row->outcome.reason)),
                        .wall_s = 0,
                        .final = false};
  }
  return std::nullopt;
}

}  // namespace aslio::experiment
