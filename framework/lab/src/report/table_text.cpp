// The tables as Markdown and CSV.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "aslio/report/encode.hpp"
#include "aslio/report/table.hpp"
#include "table_markup.hpp"

namespace aslio::report {

namespace {

bool partly_failed(const Cell& cell) { return cell.failed + cell.diverged > 0 && cell.runs > 1; }

bool any_mark(const MetricTable& table, std::size_t Cell::*count) {
  return std::any_of(table.lines.begin(), table.lines.end(), [&](const Line& line) {
    return std::any_of(line.cells.begin(), line.cells.end(), [&](const Cell& cell) { return cell.*count > 0; });
  });
}

/// A text of the study is Markdown already, but no HTML.
std::string without_tags(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<' || c == '>') {
      out += c == '<' ? "&lt;" : "&gt;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string markdown_line(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

std::string markdown_rule(std::size_t columns) {
  std::string text = "|---|";
  for (std::size_t i = 1; i < columns; ++i) text += "--:|";
  return text + "\n";
}

std::string markdown_table(const StudyFolder& study, const MetricTable& table) {
  std::vector<std::string> cells = {"sequence"};
  for (const std::string& label : study.labels) cells.push_back(markdown_cell(label));
  std::string text =
      fmt::format("\n## {}\n\n", heading(table.metric)) + markdown_line(cells) + markdown_rule(cells.size());
  for (const Line& line : table.lines) {
    cells = {markdown_cell(line.sequence)};
    for (const Cell& cell : line.cells) cells.push_back(cell_text(table.metric, cell, kMarkdown));
    text += markdown_line(cells);
  }
  return text + "\n" + footnotes(table, kMarkdown) + "\n";
}

std::vector<std::string> comparison_header(const Comparison& comparison, const Markup& markup) {
  std::vector<std::string> cells = {"method", "baseline", "sequences", "pairs", "median ratio"};
  for (const Statistic& statistic : comparison.more) cells.push_back(markup.escaped(statistic.name));
  return cells;
}

std::vector<std::string> comparison_cells(const StudyFolder& study, const Comparison& c, const Markup& markup) {
  std::vector<std::string> cells = {markup.escaped(study.labels[c.method]), markup.escaped(study.labels[c.baseline]),
                                    tally_text(c.sequences), tally_text(c.pairs), ratio_text(c, markup)};
  for (const Statistic& statistic : c.more) cells.push_back(markup.escaped(statistic.text));
  return cells;
}

std::string markdown_comparison(const StudyFolder& study, const MetricTable& table) {
  if (table.comparisons.empty()) return "";
  const auto header = comparison_header(table.comparisons[0], kMarkdown);
  std::string text =
      "\nWon / lost / tied against the baseline: sequences by their medians, and pairs of runs over the same "
      "data.\n\n" +
      markdown_line(header) + markdown_rule(header.size());
  for (const Comparison& c : table.comparisons) text += markdown_line(comparison_cells(study, c, kMarkdown));
  return text;
}

std::string markdown_failures(const StudyFolder& study) {
  std::string text;
  for (const FolderRun& run : study.runs) {
    if (run.good()) continue;
    text += markdown_line({markdown_cell(run.data), markdown_cell(run.folder.filename().string()),
                           markdown_cell(run.status), markdown_cell(run.reason)});
  }
  if (text.empty()) return text;
  return "\n## Runs that failed or diverged\n\n| data | run | status | reason |\n|---|---|---|---|\n" + text;
}

/// A cell of CSV that neither ends early nor becomes a formula in a spreadsheet.
std::string csv_text(const std::string& text) {
  const bool formula = !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
  const std::string cell = formula ? "'" + text : text;
  if (cell.find_first_of(",\"\n\r") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

}  // namespace

/// "1.2 (1.0-1.5) 1x 2-": median, range of the recordings with a figure, how many runs failed and diverged.
std::string cell_text(const Metric& metric, const Cell& cell, const Markup& markup) {
  std::string text;
  const auto out = std::back_inserter(text);
  switch (cell.mark) {
    case Mark::absent:
      return "";
    case Mark::diverged:
      text = markup.diverged;
      break;
    case Mark::failed:
      text = markup.failed;
      break;
    case Mark::value: {
      const bool best = cell.rank == Rank::best, second = cell.rank == Rank::second;
      fmt::format_to(out, "{}{}{}",
                     best     ? markup.best_begin
                     : second ? markup.second_begin
                              : "",
                     number(metric, cell.median),
                     best     ? markup.best_end
                     : second ? markup.second_end
                              : "");
    }
  }
  if (cell.with_figure > 0 && cell.recordings > 1) {
    fmt::format_to(out, "{}{}{}{}{}", markup.range_begin, number(metric, cell.min), markup.range_dash,
                   number(metric, cell.max), markup.range_end);
  }
  if (partly_failed(cell) && cell.failed > 0) fmt::format_to(out, " {}{}", cell.failed, markup.times);
  if (partly_failed(cell) && cell.diverged > 0) fmt::format_to(out, " {}{}", cell.diverged, markup.diverged);
  return text;
}

std::string heading(const Metric& metric) {
  return metric.unit.empty() ? metric.title : fmt::format("{} [{}]", metric.title, metric.unit);
}

/// What the marks of this table mean; only those that are in it.
std::string footnotes(const MetricTable& table, const Markup& markup) {
  std::string text = "Median over seeds, smallest and largest in brackets.";
  if (any_mark(table, &Cell::diverged)) {
    text +=
        fmt::format(" {}: severe divergence midway (the median run; n{}: n runs).", markup.diverged, markup.diverged);
  }
  if (any_mark(table, &Cell::failed)) {
    text += fmt::format(" {}: total failure (the median run; n{}: n runs).", markup.failed, markup.times);
  }
  if (any_mark(table, &Cell::diverged) || any_mark(table, &Cell::failed)) {
    text += " Both count as worse than any figure.";
  }
  if (table.metric.smaller_is_better) {
    text += fmt::format(" {}Best{}, {}second{}.", markup.best_begin, markup.best_end, markup.second_begin,
                        markup.second_end);
  }
  return text;
}

std::string tally_text(const Tally& tally) { return fmt::format("{} / {} / {}", tally.won, tally.lost, tally.tied); }

std::string ratio_text(const Comparison& comparison, const Markup& markup) {
  if (!comparison.ratio) return "";
  return std::isfinite(*comparison.ratio) ? fmt::format("{:.3g}", *comparison.ratio) : std::string(markup.failed);
}

std::string to_markdown(const StudyFolder& study) {
  std::string text = fmt::format("# {}\n\n", markdown_cell(study.name));
  const auto out = std::back_inserter(text);
  const auto paragraph = [&](std::string_view title, const std::string& words) {
    if (!words.empty()) fmt::format_to(out, "**{}.** {}\n\n", title, without_tags(words));
  };
  paragraph("Incomplete", study.incomplete);
  paragraph("Question", study.question);
  paragraph("Prediction", study.prediction);
  paragraph("Rule", study.rule);
  fmt::format_to(out, "{} of {} runs.\n", study.runs.size(), study.planned.value_or(study.runs.size()));
  if (!study.expectation.empty()) text += "\n## Expectation\n\n";
  for (const std::string& rule : study.expectation) fmt::format_to(out, "- {}\n", without_tags(rule));
  for (const MetricTable& table : make_tables(study, study.metrics)) {
    text += markdown_table(study, table) + markdown_comparison(study, table);
  }
  return text + markdown_failures(study);
}

std::string to_csv(const StudyFolder& study) {
  std::string text = "data,sequence,seed,order_seed,method";
  const auto out = std::back_inserter(text);
  for (const std::string& axis : study.axes) fmt::format_to(out, ",{}", csv_text(axis));
  text += ",status,reason,metric,value\n";
  for (const FolderRun& run : study.runs) {
    std::string begin = fmt::format("{},{},{},{},{}", csv_text(run.data), csv_text(run.sequence), csv_text(run.seed),
                                    csv_text(run.order_seed), csv_text(run.method));
    for (const std::string& value : run.axes) begin.append(",").append(csv_text(value));
    begin += fmt::format(",{},{}", csv_text(run.status), csv_text(run.reason));
    bool any = false;
    for (std::size_t i = 0; i < study.figures.size(); ++i) {
      if (!run.figures[i]) continue;
      fmt::format_to(out, "{},{},{}\n", begin, csv_text(study.figures[i]), *run.figures[i]);
      any = true;
    }
    if (!any) text += begin + ",,\n";
  }
  return text;
}

}  // namespace aslio::report
