#pragma once
/// What the runs of a study came to: one row per run, and tables of them.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// How a run ended. Status: that of summary.json, or `crashed`, `timeout`, `memory`, or `failed` without a summary.
struct StudyOutcome {
  std::string status, reason;
  double wall_s = 0;
  bool final = false;  ///< another run would end in the same way, under the same limits
  double limit = 0;    ///< of `timeout` and `memory`: that of the study [s, MB]

  /// Neither failed nor diverged.
  bool good() const { return status == "ok" || status == "degraded"; }
  /// Whether another call keeps it: it is final, and what it met is a limit still.
  bool stands(const StudyConfig& config) const;
};

/// A run with its figures.
struct StudyRow {
  StudyOutcome outcome;
  std::vector<std::pair<std::string, double>> figures;  ///< those there are, in the order of summary.json

  /// Neither failed nor diverged.
  bool good() const { return outcome.good(); }
  std::optional<double> figure(std::string_view name) const;
};

/// "x" of a results table is a run that failed before a tenth of the way, "-" one that failed later. `failed_at`: the
/// figure of that name, which runs without a reference do not have.
bool failed_late(std::string_view status, const std::optional<double>& failed_at);

/// Writes `run_key.json`, the mark of a finished run.
void write_outcome(const std::filesystem::path& folder, const std::string& key, const StudyOutcome& outcome);
/// Of a run folder that was finished under this key, or (empty) under any; nothing otherwise, nor where the outcome is
/// that of a summary that cannot be read any more.
std::optional<StudyOutcome> read_outcome(const std::filesystem::path& folder, const std::string& key);

/// Status and reason of summary.json; nothing when there is none, or none that can be read.
std::optional<StudyOutcome> read_summary_outcome(const std::filesystem::path& folder);
/// The row of a finished run; figures from its summary.json.
StudyRow read_row(const std::filesystem::path& folder, const StudyOutcome& outcome);

/// results.csv: a line per row that there is, in the order of the runs.
std::string results_csv(const Study& study, const std::vector<StudyRun>& runs,
                        const std::vector<std::optional<StudyRow>>& rows);
/// table.md: what the study asks; per metric a table of sequences and methods with medians over seeds, and the
/// comparison with the baseline; the failures with their reasons.
std::string results_markdown(const Study& study, const std::vector<StudyRun>& runs,
                             const std::vector<std::optional<StudyRow>>& rows);

/// Of study.json. A file of another schema is of another version.
inline constexpr std::string_view kStudyJsonSchema = "aslio/study_results/1";

/// study.json, for the report, the analysis scripts and other programs: the study's texts, how many runs are planned
/// and done, its metrics, methods (label, baseline, keys that differ from it), the judged expectation, methods with
/// identical results. The figures of the runs are in results.csv and statistics.csv.
std::string study_json(const Study& study, const std::vector<StudyRun>& runs,
                       const std::vector<std::optional<StudyRow>>& rows);

/// What people read in place of a method's name; empty: the name.
std::string method_label(const Study& study, const StudyMethod& method);

/// Writes study.json, results.csv, statistics.csv (study_statistics.hpp) and table.md. Throws DataError.
void write_study_tables(const Study& study, const std::vector<StudyRun>& runs,
                        const std::vector<std::optional<StudyRow>>& rows, const std::filesystem::path& output);

}  // namespace aslio::experiment
