// table.md: medians over seeds, and who wins against the baseline.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

#include "aslio/experiment/study_results.hpp"

namespace aslio::experiment {

namespace {

constexpr double kFailed = std::numeric_limits<double>::infinity();
constexpr std::array<std::string_view, 6> kSmallerIsBetter = {"ate_m",        "ate_deg",     "rpe",
                                                              "end_to_end_m", "cpu_s_per_s", "peak_rss_mb"};

bool comparable(const std::string& metric) {
  return std::find(kSmallerIsBetter.begin(), kSmallerIsBetter.end(), metric) != kSmallerIsBetter.end();
}

/// Replicates of one method on one sequence. A failure counts as worse than any figure: it is never left out.
struct Replicates {
  std::vector<double> values;  ///< of all runs with a figure or a failure, sorted; failures are infinite
  std::size_t failed = 0;

  /// Nothing when there is no run; infinite when a middle value is a failure.
  std::optional<double> median() const {
    if (values.empty()) return std::nullopt;
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  }
};

struct Tally {
  int won = 0, lost = 0, tied = 0;

  void count(double value, double baseline) {
    if (value < baseline) {
      ++won;
    } else if (value > baseline) {
      ++lost;
    } else {
      ++tied;
    }
  }
};

class Tables {
 public:
  Tables(const Study& study, const std::vector<StudyRun>& runs, const std::vector<std::optional<StudyRow>>& rows)
      : study_(study), runs_(runs), rows_(rows) {
    for (const StudyData& data : study.data) {
      if (std::find(sequences_.begin(), sequences_.end(), data.sequence) == sequences_.end()) {
        sequences_.push_back(data.sequence);
      }
    }
  }

  std::string text() const {
    const StudyConfig& config = study_.config;
    const auto done = std::count_if(rows_.begin(), rows_.end(), [](const auto& row) { return row.has_value(); });
    std::string text = fmt::format("# {}\n\n", study_.name);
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "**Question.** {}\n\n**Prediction.** {}\n\n**Rule.** {}\n\n", paragraph(config.question),
                   paragraph(config.prediction), paragraph(config.rule));
    fmt::format_to(out,
                   "{} of {} runs. A cell is the median over seeds with smallest and largest in brackets; a run that "
                   "failed or diverged counts as worse than any figure, `2x` tells how many did, `x` that the median "
                   "is one of them, `-` that there is no figure.\n",
                   done, runs_.size());
    for (const std::string& metric : config.metrics) {
      text += metric_table(metric);
      if (comparable(metric)) text += comparison(metric);
    }
    return text + failures();
  }

 private:
  /// A text of several lines would end the paragraph.
  static std::string paragraph(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (text.ends_with(' ')) text.pop_back();
    return text;
  }

  /// Figure of a run; infinite for a failure, nothing when the run or the figure is not there.
  std::optional<double> value(std::size_t run, const std::string& metric) const {
    if (!rows_[run]) return std::nullopt;
    return rows_[run]->good() ? rows_[run]->figure(metric) : std::optional(kFailed);
  }

  Replicates replicates(const std::string& sequence, std::size_t method, const std::string& metric) const {
    Replicates out;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[i].method != method || study_.data[runs_[i].data].sequence != sequence) continue;
      if (const auto v = value(i, metric)) {
        out.values.push_back(*v);
        if (*v == kFailed) ++out.failed;
      }
    }
    std::sort(out.values.begin(), out.values.end());
    return out;
  }

  static std::string cell(const Replicates& r) {
    const auto median = r.median();
    if (!median) return "-";
    std::string text = *median == kFailed ? "x" : fmt::format("{:.4g}", *median);
    const std::size_t good = r.values.size() - r.failed;
    if (good > 0 && r.values.size() > 1) text += fmt::format(" ({:.4g}-{:.4g})", r.values[0], r.values[good - 1]);
    if (r.failed > 0 && r.values.size() > 1) text += fmt::format(" {}x", r.failed);
    return text;
  }

  std::string metric_table(const std::string& metric) const {
    std::string text = fmt::format("\n## {}\n\n| sequence |", metric);
    const auto out = std::back_inserter(text);
    for (const StudyMethod& method : study_.methods) fmt::format_to(out, " {} |", method.name);
    text += "\n|---|";
    for (std::size_t m = 0; m < study_.methods.size(); ++m) text += "---|";
    text += '\n';
    for (const std::string& sequence : sequences_) {
      fmt::format_to(out, "| {} |", sequence);
      for (std::size_t m = 0; m < study_.methods.size(); ++m) {
        fmt::format_to(out, " {} |", cell(replicates(sequence, m, metric)));
      }
      text += '\n';
    }
    return text;
  }

  Tally by_sequence(std::size_t method, std::size_t baseline, const std::string& metric) const {
    Tally tally;
    for (const std::string& sequence : sequences_) {
      const auto a = replicates(sequence, method, metric).median(), b = replicates(sequence, baseline, metric).median();
      if (a && b) tally.count(*a, *b);
    }
    return tally;
  }

  Tally by_pair(std::size_t method, std::size_t baseline, const std::string& metric) const {
    Tally tally;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[i].method != method) continue;
      // The runs over the same data with the same order seed stand together, by method.
      const auto a = value(i, metric), b = value(i - method + baseline, metric);
      if (a && b) tally.count(*a, *b);
    }
    return tally;
  }

  std::string comparison(const std::string& metric) const {
    std::string text;
    const auto out = std::back_inserter(text);
    for (std::size_t m = 0; m < study_.methods.size(); ++m) {
      if (!study_.baseline[m]) continue;
      const Tally s = by_sequence(m, *study_.baseline[m], metric), p = by_pair(m, *study_.baseline[m], metric);
      fmt::format_to(out, "| {} | {} | {} / {} / {} | {} / {} / {} |\n", study_.methods[m].name,
                     study_.methods[*study_.baseline[m]].name, s.won, s.lost, s.tied, p.won, p.lost, p.tied);
    }
    if (text.empty()) return text;
    return fmt::format(
        "\nWon / lost / tied against the baseline, smaller is better: sequences by their medians, and pairs of runs "
        "over the same data.\n\n| method | baseline | sequences | pairs |\n|---|---|---|---|\n{}",
        text);
  }

  std::string failures() const {
    std::string text;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (!rows_[i] || rows_[i]->good()) continue;
      std::string reason = paragraph(rows_[i]->outcome.reason);
      std::replace(reason.begin(), reason.end(), '|', '/');
      text += fmt::format("| {} | {} | {} | {} |\n", study_.data[runs_[i].data].name, runs_[i].folder,
                          rows_[i]->outcome.status, reason);
    }
    if (text.empty()) return text;
    return "\n## Failures\n\n| data | run | status | reason |\n|---|---|---|---|\n" + text;
  }

  const Study& study_;
  const std::vector<StudyRun>& runs_;
  const std::vector<std::optional<StudyRow>>& rows_;
  std::vector<std::string> sequences_;
};

}  // namespace

std::string results_markdown(const Study& study, const std::vector<StudyRun>& runs,
                             const std::vector<std::optional<StudyRow>>& rows) {
  return Tables(study, runs, rows).text();
}

}  // namespace aslio::experiment
