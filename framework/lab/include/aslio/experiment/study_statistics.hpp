#pragma once
/// How sure a study can be of its tables: spread over seeds, and methods against their baseline.

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/statistics/bootstrap.hpp"

namespace aslio::experiment {

/// A run that failed or diverged, as a figure: worse than any.
inline constexpr double kFailedFigure = std::numeric_limits<double>::infinity();

/// Is a smaller figure of this name a better one? Of the others none is better.
bool smaller_is_better(std::string_view metric);

/// Replicates of one method on one sequence: its recordings, each by the median over the order seeds, which change
/// little and are no replicates. A failure is a value, kFailedFigure.
struct Replicates {
  std::vector<double> values;  ///< of all recordings with a figure or a failure, sorted
  std::size_t runs = 0;        ///< with a figure or a failure
  std::size_t failed = 0;      ///< of them
  std::size_t late = 0;        ///< of them, those that failed on the way

  std::optional<double> median() const;
};

struct Tally {
  std::size_t won = 0, lost = 0, tied = 0;
  /// Smaller wins.
  void count(double value, double baseline);
};

/// Two methods on the same recording, by the medians over the order seeds for which both have a figure or a failure.
struct Pair {
  std::optional<double> value, baseline;  ///< both or none
  std::size_t seeds = 0;                  ///< order seeds
};

/// A method against its baseline in one metric: over sequences by their medians over the recordings that both have, and
/// over pairs. Two failures are a tie.
struct Comparison {
  std::size_t method = 0, baseline = 0;
  Tally sequences, pairs;
  std::size_t failed = 0, baseline_failed = 0;   ///< pairs in which it failed
  std::optional<double> ratio;                   ///< median over the pairs of figure / figure of the baseline
  std::optional<statistics::Interval> interval;  ///< of the ratio, 95 %, bootstrap clustered by sequence
  /// Rank-biserial correlation of the logarithms of the ratios; -1: below the baseline in all pairs.
  std::optional<double> effect;
  std::optional<double> p;  ///< Wilcoxon's signed-rank test of those logarithms, pairs taken as independent
  /// The same test of one logarithm per sequence, that of its median ratio: seeds of one scene may share its world.
  std::optional<double> p_sequences;
  std::optional<double> p_holm;  ///< corrected for all comparisons of this metric
};

/// The figures of a study by sequence and method. Refers to what it was made from.
class StudyFigures {
 public:
  StudyFigures(const Study& study, const std::vector<StudyRun>& runs, const std::vector<std::optional<StudyRow>>& rows);

  /// In the order of the study file.
  const std::vector<std::string>& sequences() const { return sequences_; }
  /// kFailedFigure for a failure, for the end-to-end error also where a run has failed on the way, as its distance from
  /// the truth tells, and come back; nothing when the run or the figure is not there.
  std::optional<double> value(std::size_t run, const std::string& metric) const;
  Pair pair(std::size_t data, std::size_t method, std::size_t baseline, const std::string& metric) const;
  Replicates replicates(std::size_t sequence, std::size_t method, const std::string& metric) const;
  /// All methods that have a baseline, in their order. Empty for a metric of which none is better.
  std::vector<Comparison> comparisons(const std::string& metric) const;

 private:
  Comparison compare(std::size_t method, std::size_t baseline, const std::string& metric) const;

  const Study& study_;
  const std::vector<std::optional<StudyRow>>& rows_;
  std::vector<std::string> sequences_;
  std::vector<std::vector<std::size_t>> data_of_;    ///< by sequence
  std::vector<std::vector<std::size_t>> groups_of_;  ///< by data: first run of each order seed, by method from there
};

/// statistics.csv: of every metric a line per sequence and method, and one per comparison (docs/experiments.md).
std::string statistics_csv(const Study& study, const StudyFigures& figures);

/// Two methods whose runs gave the same figures to the last bit, on all data they both finished.
struct IdenticalMethods {
  std::size_t first = 0, second = 0;
  std::size_t runs = 0;  ///< that were compared
};

/// What a clock or the kernel decides does not count. Failures do not count, either.
std::vector<IdenticalMethods> identical_methods(const Study& study, const std::vector<StudyRun>& runs,
                                                const std::vector<std::optional<StudyRow>>& rows);

/// What to tell of them.
std::string identical_text(const Study& study, const IdenticalMethods& same);

/// Methods whose runs gave the same figures to the last bit for every order seed, on all recordings with two such runs
/// or more: what to tell of each.
std::vector<std::string> identical_orders(const Study& study, const std::vector<StudyRun>& runs,
                                          const std::vector<std::optional<StudyRow>>& rows);

}  // namespace aslio::experiment
