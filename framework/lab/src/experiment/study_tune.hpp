#pragma once
/// Equal tuning: candidates for every pipeline of a study, drawn from a declared space, and the pipeline files of the
/// best ones.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_results.hpp"
#include "study_axes.hpp"

namespace aslio::experiment {

inline constexpr const char* kCandidateColumn = "candidate";

/// Why a method cannot be tuned as the others are; empty: it can. Pre: the recordings of the study are known.
std::string tuning_problem(const Study& study, const StudyMethodConfig& method);

/// What is wrong with the methods that the space names; empty: nothing.
std::string space_problem(const StudyConfig& config);

/// The candidates of a method, as many as the budget allows over the recordings: the first one as written, the others
/// drawn. A parameter that several methods have gets the same values in all. A program of others has the first one
/// alone.
std::vector<AxisPoint> candidate_points(const Study& study, const StudyMethodConfig& method);

/// The best candidate of a method: fewest failures, then the smallest geometric mean of the objective over recordings.
struct Tuned {
  std::string base;                     ///< name of the method
  std::size_t method = 0, untuned = 0;  ///< indices in Study::methods
  std::size_t candidates = 0, failures = 0;
  double objective = 0;                     ///< of the best one
  std::optional<double> untuned_objective;  ///< nothing where the untuned pipeline failed
};

/// Of the methods all of whose runs are there.
std::vector<Tuned> best_candidates(const Study& study, const std::vector<StudyRun>& runs,
                                   const std::vector<std::optional<StudyRow>>& rows);

/// Writes tuning.csv (a line per candidate) and tuned/METHOD.yaml with where it comes from in its first lines.
void write_tuning(const Study& study, const std::vector<StudyRun>& runs,
                  const std::vector<std::optional<StudyRow>>& rows, const std::filesystem::path& output);

/// Names of the recordings on which a pipeline file was tuned that are among `data`.
std::vector<std::string> tuned_on(const std::filesystem::path& pipeline, const std::vector<StudyData>& data);

}  // namespace aslio::experiment
