#pragma once
/// What `aslio experiment` has left in its output folder, read back without the study file: of another machine, or of a
/// study that is still at work.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::report {

/// A line of results.csv.
struct FolderRun {
  std::string data, sequence, seed, order_seed, method;
  std::vector<std::string> axes;  ///< values, by StudyFolder::axes
  std::string status, reason;
  std::vector<std::optional<double>> figures;  ///< by StudyFolder::figures
  std::filesystem::path folder;                ///< with summary.json and so on; may lack any of them

  /// Neither failed nor diverged.
  bool good() const { return status == "ok" || status == "degraded"; }
};

/// How sure the comparison of a method with its baseline is, as `aslio experiment` has worked it out.
struct FolderStatistic {
  std::string metric, method;
  std::optional<double> low, high;    ///< 95 % interval of the median ratio; infinite where it is a failure
  std::optional<double> effect;       ///< rank-biserial correlation, -1: below the baseline throughout
  std::optional<double> p, p_holm;    ///< Wilcoxon's signed-rank test, alone and corrected
  std::optional<double> p_sequences;  ///< of the sequences' median ratios
};

struct StudyFolder {
  std::filesystem::path folder;
  std::string name, question, prediction, rule;
  std::string verdict;                 ///< Markdown of verdict.md; empty when there is none
  std::optional<std::size_t> planned;  ///< how many runs the study has
  std::vector<std::string> axes, figures;
  std::vector<std::string> data, sequences, methods;  ///< in the order of the runs
  std::vector<std::string> labels;                    ///< of the methods, for people; the name where there is none
  std::vector<std::string> metrics;                   ///< that the study asks for, as far as there are figures
  /// By method: the one to compare it with.
  std::vector<std::optional<std::size_t>> baseline;
  std::vector<FolderRun> runs;
  std::vector<FolderStatistic> statistics;
  /// What the study expected, rule by rule: Markdown, "RULE: **holds**".
  std::vector<std::string> expectation;
  std::string incomplete;              ///< what the folder lacks and what completes it; empty when it is whole
  std::vector<std::string> identical;  ///< what study.json says of methods without a difference

  /// Index in `methods`, `figures`; nothing when there is no such.
  std::optional<std::size_t> method(std::string_view name) const;
  std::optional<std::size_t> figure(std::string_view name) const;
};

/// Reads results.csv, statistics.csv, study.json and verdict.md of a study; of a folder without results.csv the run in
/// it, or the runs in its sub-folders. Throws DataError when there is neither, or a file is not what it has to be:
/// file, line, remedy.
StudyFolder read_study_folder(const std::filesystem::path& folder);

/// A file's content; nothing when it cannot be opened.
std::optional<std::string> read_file(const std::filesystem::path& path);

}  // namespace aslio::report
