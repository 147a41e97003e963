#pragma once
/// Two folders of studies side by side: another version of the program, another machine, another parameter.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/study_statistics.hpp"

namespace aslio::experiment {

/// A figure of one method over the runs that both have.
struct FigureComparison {
  std::string method, figure;
  std::size_t pairs = 0, different = 0;  ///< runs with this figure, or a failure, in both; those not equal to the bit
  std::optional<double> median_a, median_b;  ///< failures are infinite
  std::optional<double> difference;          ///< median of B - A over the pairs where both have a figure
  Tally tally;                               ///< smaller wins, for B
  std::optional<double> p;                   ///< Wilcoxon's signed-rank test of B - A
};

struct FolderComparison {
  std::size_t shared = 0;                   ///< runs in both: same data, method and order seed
  std::vector<std::string> only_a, only_b;  ///< "DATA/METHOD", with /SEED where there are order seeds
  std::vector<std::string> other_data;      ///< data of the same name that are not the same
  std::vector<std::string> outcomes;        ///< "DATA/METHOD: ok -> failed"
  std::vector<std::string> configurations;  ///< "METHOD: window.period: 0.1 -> 0.05"
  std::vector<std::string> different;       ///< runs of which some figure differs, those of clocks left out
  std::vector<FigureComparison> figures;

  /// Same runs, outcomes and figures to the bit.
  bool same() const;
};

/// Reads results.csv, and plan.csv and runs where they are there. Throws ConfigError for a folder without a study.
FolderComparison compare_folders(const std::filesystem::path& a, const std::filesystem::path& b);
std::string to_text(const FolderComparison& comparison);

}  // namespace aslio::experiment
