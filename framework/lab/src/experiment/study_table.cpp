// table.md: medians over seeds, and who wins against the baseline.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "aslio/experiment/study_expectation.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/experiment/study_statistics.hpp"
#include "aslio/io/writers.hpp"
#include "study_tune.hpp"

namespace aslio::experiment {

namespace {

constexpr std::string_view kEndToEndFootnote =
    "\nWhatever its status, a run has also failed when its position is not finite, or no update was accepted for more "
    "than 1 s. So has one whose position is off by more than 2 m and 5 % of the path, with the first second aligned to "
    "the truth.\n";

class Tables {
 public:
  Tables(const Study& study, const std::vector<StudyRun>& runs, const std::vector<std::optional<StudyRow>>& rows)
      : study_(study), runs_(runs), rows_(rows), figures_(study, runs, rows) {}

  std::string text() const {
    const StudyConfig& config = study_.config;
    const auto done = std::count_if(rows_.begin(), rows_.end(), [](const auto& row) { return row.has_value(); });
    std::string text = fmt::format("# {}\n\n", study_.name);
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "**Question.** {}\n\n**Prediction.** {}\n\n**Rule.** {}\n\n", one_line(config.question),
                   one_line(config.prediction), one_line(config.rule));
    fmt::format_to(out,
                   "{} of {} runs. A cell is the median over seeds with minimum and maximum in brackets. Of several "
                   "order seeds it takes the median of each recording first. A run that failed or diverged counts as "
                   "worse than any figure: `x` if before a tenth of the path, `-` if later. If one stands alone, the "
                   "median is such a run; `2x` and `1-` give their number. An empty cell has no figure.\n",
                   done, runs_.size());
    text += expectation();
    for (const std::string& metric : config.metrics) {
      text += metric_table(metric);
      if (metric == "end_to_end_m") text += kEndToEndFootnote;
      text += comparison(metric);
    }
    return text + differences() + labels() + identical() + failures();
  }

 private:
  std::string expectation() const {
    const std::vector<JudgedRule> rules = judge_expectation(study_, runs_, rows_, figures_);
    if (rules.empty()) return {};
    std::string text = fmt::format("\n## Expectation\n\nAll in all: **{}**\n\n", to_text(overall(rules)));
    for (const JudgedRule& rule : rules) text += fmt::format("- {}\n", to_markdown(rule));
    return text;
  }

  static std::string cell(const Replicates& r) {
    const auto median = r.median();
    if (!median) return "";
    const std::string_view mark = 2 * r.late > r.failed ? "-" : "x";
    std::string text = *median == kFailedFigure ? std::string(mark) : fmt::format("{:.4g}", *median);
    const auto good =
        static_cast<std::size_t>(std::lower_bound(r.values.begin(), r.values.end(), kFailedFigure) - r.values.begin());
    if (good > 0 && r.values.size() > 1) text += fmt::format(" ({:.4g}-{:.4g})", r.values[0], r.values[good - 1]);
    if (r.runs < 2) return text;
    if (r.failed > r.late) text += fmt::format(" {}x", r.failed - r.late);
    if (r.late > 0) text += fmt::format(" {}-", r.late);
    return text;
  }

  std::string metric_table(const std::string& metric) const {
    std::string text = fmt::format("\n## {}\n\n| sequence |", metric);
    const auto out = std::back_inserter(text);
    for (const StudyMethod& method : study_.methods) fmt::format_to(out, " {} |", method.name);
    text += "\n|---|";
    for (std::size_t m = 0; m < study_.methods.size(); ++m) text += "---|";
    text += '\n';
    for (std::size_t s = 0; s < figures_.sequences().size(); ++s) {
      fmt::format_to(out, "| {} |", figures_.sequences()[s]);
      for (std::size_t m = 0; m < study_.methods.size(); ++m) {
        fmt::format_to(out, " {} |", cell(figures_.replicates(s, m, metric)));
      }
      text += '\n';
    }
    return text;
  }

  /// "0.831 (0.79-0.88)"; failures as x.
  static std::string ratio_text(const Comparison& c) {
    const auto number = [](double v) { return v == kFailedFigure ? std::string("x") : fmt::format("{:.3g}", v); };
    if (!c.ratio) return "-";
    std::string text = number(*c.ratio);
    if (c.interval) text += fmt::format(" ({}-{})", number(c.interval->low), number(c.interval->high));
    return text;
  }

  static std::string p_text(const std::optional<double>& p) {
    if (!p) return "-";
    return *p < 0.001 ? std::string("< 0.001") : fmt::format("{:.3f}", *p);
  }

  std::string comparison(const std::string& metric) const {
    std::string text;
    const auto out = std::back_inserter(text);
    for (const Comparison& c : figures_.comparisons(metric)) {
      fmt::format_to(out, "| {} | {} | {} / {} / {} | {} / {} / {} | {} | {} | {} | {} | {} |\n",
                     study_.methods[c.method].name, study_.methods[c.baseline].name, c.sequences.won, c.sequences.lost,
                     c.sequences.tied, c.pairs.won, c.pairs.lost, c.pairs.tied, ratio_text(c),
                     c.effect ? fmt::format("{:+.2f}", *c.effect) : "-", p_text(c.p), p_text(c.p_holm),
                     p_text(c.p_sequences));
    }
    if (text.empty()) return text;
    return fmt::format(
        "\nAgainst the baseline, smaller is better. Won / lost / tied: sequences by their medians over the recordings "
        "that both have, and pairs on the same recording, by medians over order seeds. Ratio: median over the pairs, "
        "with the 95 % interval of a bootstrap clustered by sequence, from 5 pairs on. Effect: rank-biserial "
        "correlation; -1 means below the baseline in all pairs. p: Wilcoxon's signed-rank test, from 6 pairs on. "
        "p (Holm): with Holm's correction for the lines of this table. Both treat the pairs as independent, so they "
        "are "
        "too small where the recordings of a sequence share a world. p (sequences): the same test of the sequences' "
        "median ratios, from 6 sequences on.\n\n"
        "| method | baseline | sequences | pairs | ratio | effect | p | p (Holm) | p (sequences) "
        "|\n|---|---|---|---|---|---|---|---|---|\n{}",
        text);
  }

  /// A comparison is worth what its two sides have in common.
  std::string differences() const {
    std::string text;
    for (std::size_t m = 0; m < study_.methods.size(); ++m) {
      if (!study_.baseline[m]) continue;
      const StudyMethod& baseline = study_.methods[*study_.baseline[m]];
      const auto keys = differing_keys(study_.methods[m], baseline);
      text += fmt::format("| {} | {} | {} |\n", study_.methods[m].name, baseline.name,
                          keys.empty() ? "nothing" : fmt::format("{}", fmt::join(keys, ", ")));
    }
    if (text.empty()) return text;
    return "\n## What is compared\n\n| method | baseline | differs in |\n|---|---|---|\n" + text;
  }

  std::string labels() const {
    std::string text;
    for (const StudyMethod& method : study_.methods) {
      const std::string label = method_label(study_, method);
      if (!label.empty()) text += fmt::format("- {}: {}\n", method.name, label);
    }
    return text.empty() ? text : "\n## Labels\n\n" + text;
  }

  std::string identical() const {
    std::string text;
    for (const IdenticalMethods& same : identical_methods(study_, runs_, rows_)) {
      text += fmt::format("- {}\n", identical_text(study_, same));
    }
    for (const std::string& line : identical_orders(study_, runs_, rows_)) text += fmt::format("- {}\n", line);
    return text.empty() ? text : "\n## Identical results\n\n" + text;
  }

  std::string failures() const {
    std::string text;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (!rows_[i] || rows_[i]->good()) continue;
      std::string reason = one_line(rows_[i]->outcome.reason);
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
  StudyFigures figures_;
};

/// The study as it was run.
std::string resolved_text(const Study& study) {
  return fmt::format("# {}: every key at its effective value; paths are relative to {}\n{}",
                     study.path.filename().string(),
                     std::filesystem::absolute(study.path).lexically_normal().parent_path().string(), study.resolved);
}

}  // namespace

std::string method_label(const Study& study, const StudyMethod& method) {
  std::string label = one_line(study.config.methods[method.entry].label);
  if (label.empty()) return label;
  for (std::size_t k = 0; k < method.axes.size(); ++k) {
    const std::string& axis = study.axes[k];
    label += fmt::format(", {} {}", axis.substr(axis.rfind('.') + 1), method.axes[k]);
  }
  return label;
}

std::string results_markdown(const Study& study, const std::vector<StudyRun>& runs,
                             const std::vector<std::optional<StudyRow>>& rows) {
  return Tables(study, runs, rows).text();
}

void write_study_tables(const Study& study, const std::vector<StudyRun>& runs,
                        const std::vector<std::optional<StudyRow>>& rows, const std::filesystem::path& output) {
  const auto write = [&](const char* name, const std::string& text) {
    io::AtomicFile file(output / name);
    file.write(text);
    file.close();
  };
  write("study.yaml", resolved_text(study));
  write("results.csv", results_csv(study, runs, rows));
  write("statistics.csv", statistics_csv(study, StudyFigures(study, runs, rows)));
  write("table.md", results_markdown(study, runs, rows));
  write("study.json", study_json(study, runs, rows));
  if (study.config.tune.given()) write_tuning(study, runs, rows, output);
}

}  // namespace aslio::experiment
