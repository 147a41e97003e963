#pragma once
/// The tables of a study: one model, which Markdown, LaTeX, CSV and the page show.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/report/study_folder.hpp"

namespace aslio::report {

/// How a figure is shown.
struct Metric {
  std::string name;               ///< column of results.csv
  std::string title, unit;        ///< for people
  double scale = 1;               ///< from the figure to `unit`
  bool smaller_is_better = true;  ///< false: nothing is better or worse
  int decimals = 3;               ///< of the scaled value, the same for all cells of a table
};

/// value: the median is a figure. diverged: it is a run that diverged midway, "-". failed: one that failed as a whole,
/// "x". absent: no run, or runs without this figure.
enum class Mark : unsigned char { value, diverged, failed, absent };
enum class Rank : unsigned char { none, best, second };

/// The replicates of one method on one sequence. A run that failed or diverged counts as worse than any figure: it is
/// never left out. Values are unscaled.
struct Cell {
  Mark mark = Mark::absent;
  double median = 0;            ///< of the recordings; only with Mark::value
  double min = 0, max = 0;      ///< of the recordings with a figure; 0 where there is none
  std::size_t recordings = 0;   ///< each the median over its order seeds
  std::size_t with_figure = 0;  ///< of them, those whose median is no failure
  std::size_t runs = 0;         ///< with a figure, or failed
  std::size_t failed = 0;       ///< of them, those that neither ended well nor diverged
  std::size_t diverged = 0;
  Rank rank = Rank::none;  ///< in its line
};

struct Line {
  std::string sequence;
  std::vector<Cell> cells;  ///< by method
};

struct Tally {
  std::size_t won = 0, lost = 0, tied = 0;
};

/// One more column of a comparison, as a test or an interval.
struct Statistic {
  std::string name, text;
};

/// A method against its baseline; smaller wins, a failure loses against any figure.
struct Comparison {
  std::size_t method = 0, baseline = 0;
  Tally sequences;              ///< by medians over the recordings that both have
  Tally pairs;                  ///< runs over the same data
  std::optional<double> ratio;  ///< median of the ratios of pairs; infinite when it is a failure
  std::vector<Statistic> more;
};

struct MetricTable {
  Metric metric;
  std::vector<Line> lines;  ///< by sequence
  std::vector<Comparison> comparisons;
};

/// One table per metric.
std::vector<MetricTable> make_tables(const StudyFolder& study, const std::vector<std::string>& metrics);

/// Scaled, with the decimals of the metric.
std::string number(const Metric& metric, double value);

/// Every table of the study's metrics, comparisons, failures, and what the marks mean.
std::string to_markdown(const StudyFolder& study);
/// What stands in the rows of a table in LaTeX. automatic: methods where there are more of them than sequences.
enum class LatexRows : unsigned char { automatic, sequences, methods };

/// The same as LaTeX with booktabs: the best bold, the second underlined. Each table has a \label and a width that
/// fits a paper of two columns: one column, both (table*), or parts below each other.
std::string to_latex(const StudyFolder& study, LatexRows rows = LatexRows::automatic);
/// Long form: a line per run and figure. Text that a spreadsheet would take for a formula is preceded by '.
std::string to_csv(const StudyFolder& study);

}  // namespace aslio::report
