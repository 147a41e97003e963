// The tables as LaTeX that fits a paper of two columns.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "table_markup.hpp"

namespace aslio::report {

namespace {

using TextRow = std::vector<std::string>;

/// Characters of \footnotesize, with the gaps between columns, that fit one column of a paper, and both.
constexpr std::size_t kOneColumn = 50, kBothColumns = 100;
/// What a gap between columns takes, in characters.
constexpr std::size_t kGap = 2;

/// Width on paper [characters]: commands and braces take no room, "$\times$" that of one.
std::size_t width_of(const std::string& text) {
  std::size_t width = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\') {
      std::size_t end = i + 1;
      while (end < text.size() && ((text[end] >= 'a' && text[end] <= 'z') || (text[end] >= 'A' && text[end] <= 'Z'))) {
        ++end;
      }
      const std::string command = text.substr(i, end - i);
      const bool style = command == "\\textbf" || command == "\\underline" || command == "\\scriptsize";
      if (!style) ++width;
      i = end > i + 1 ? end - 1 : i + 1;
    } else if (c != '{' && c != '}' && c != '$' && (static_cast<unsigned char>(c) & 0xc0U) != 0x80U) {
      ++width;
    }
  }
  return width;
}

std::vector<std::size_t> widths_of(const std::vector<TextRow>& rows) {
  std::vector<std::size_t> widths(rows[0].size());
  for (const TextRow& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]) + kGap);
  }
  return widths;
}

/// Columns [begin, end) that go side by side after the first; more than one part where both columns are too narrow.
std::vector<std::pair<std::size_t, std::size_t>> parts_of(const std::vector<std::size_t>& widths) {
  std::vector<std::pair<std::size_t, std::size_t>> parts;
  for (std::size_t begin = 1; begin < widths.size();) {
    std::size_t end = begin + 1, width = widths[0] + widths[begin];
    while (end < widths.size() && width + widths[end] <= kBothColumns) width += widths[end++];
    parts.emplace_back(begin, end);
    begin = end;
  }
  return parts;
}

std::string tabular(const std::vector<TextRow>& rows, std::size_t begin, std::size_t end) {
  std::string text = fmt::format("\\begin{{tabular}}{{@{{}}l{}@{{}}}}\n\\toprule\n", std::string(end - begin, 'r'));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += rows[i][0];
    for (std::size_t k = begin; k < end; ++k) text += " & " + rows[i][k];
    text += i == 0 ? " \\\\\n\\midrule\n" : " \\\\\n";
  }
  return text + "\\bottomrule\n\\end{tabular}\n";
}

/// The first row is the head. What is too wide for one column spans both; what is too wide for both goes below itself.
std::string float_of(const std::vector<TextRow>& rows, const std::string& caption, const std::string& label,
                     const std::string& notes) {
  const auto widths = widths_of(rows);
  std::size_t width = 0;
  for (const std::size_t each : widths) width += each;
  const char* name = width <= kOneColumn ? "table" : "table*";
  std::string text = fmt::format(
      "\n\\begin{{{}}}[t]\n\\centering\\footnotesize\\setlength{{\\tabcolsep}}{{4pt}}\n\\caption{{{}}}\n\\label{{{}}}"
      "\n",
      name, caption, label);
  std::string_view between;
  for (const auto& [begin, end] : parts_of(widths)) {
    text += std::string(between) + tabular(rows, begin, end);
    between = "\n\\medskip\n";
  }
  return text + fmt::format("\n\\smallskip\n{}\n\\end{{{}}}\n", notes, name);
}

/// A name that \label takes: letters and digits, others as "-".
std::string slug(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    out += plain ? c : '-';
  }
  return out;
}

std::string label_of(const StudyFolder& study, const MetricTable& table, std::string_view kind = "") {
  return fmt::format("tab:{}:{}{}", slug(study.name), slug(table.metric.name), kind);
}

/// A wide study is a long table, which is easier to place.
bool methods_in_rows(const StudyFolder& study, LatexRows rows) {
  return rows == LatexRows::methods || (rows == LatexRows::automatic && study.methods.size() > study.sequences.size());
}

std::vector<TextRow> transposed(const std::vector<TextRow>& rows) {
  std::vector<TextRow> out(rows[0].size(), TextRow(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows[i].size(); ++k) out[k][i] = rows[i][k];
  }
  return out;
}

std::string metric_table(const StudyFolder& study, const MetricTable& table, LatexRows order) {
  std::vector<TextRow> rows = {{"Sequence"}};
  for (const std::string& label : study.labels) rows[0].push_back(latex_escaped(label));
  for (const Line& line : table.lines) {
    rows.push_back({latex_escaped(line.sequence)});
    for (const Cell& cell : line.cells) rows.back().push_back(cell_text(table.metric, cell, kLatex));
  }
  if (methods_in_rows(study, order)) {
    rows[0][0] = "Method";
    rows = transposed(rows);
  }
  return float_of(rows, fmt::format("{}: {}.", latex_escaped(study.name), latex_escaped(heading(table.metric))),
                  label_of(study, table), footnotes(table, kLatex));
}

/// The short head of a column; its note says what it stands for.
std::string short_head(const std::string& name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kShort = {{{"95 % of ratio", "95\\,\\% CI"},
                                                                                    {"effect", "$r$"},
                                                                                    {"p", "$p$"},
                                                                                    {"p (Holm)", "$p_{H}$"},
                                                                                    {"p (sequences)", "$p_{S}$"}}};
  for (const auto& [full, brief] : kShort) {
    if (name == full) return std::string(brief);
  }
  return latex_escaped(name);
}

std::string comparison_table(const StudyFolder& study, const MetricTable& table) {
  if (table.comparisons.empty()) return "";
  std::vector<TextRow> rows = {{"Method", "Baseline", "Seq.", "Pairs", "Ratio"}};
  for (const Statistic& statistic : table.comparisons[0].more) rows[0].push_back(short_head(statistic.name));
  for (const Comparison& c : table.comparisons) {
    rows.push_back({latex_escaped(study.labels[c.method]), latex_escaped(study.labels[c.baseline]),
                    tally_text(c.sequences), tally_text(c.pairs), ratio_text(c, kLatex)});
    for (const Statistic& statistic : c.more) rows.back().push_back(latex_escaped(statistic.text));
  }
  std::string notes =
      "Seq., Pairs: sequences and pairs of runs won / lost / tied against the baseline. Ratio: median over the pairs, "
      "below 1 is better.";
  if (!table.comparisons[0].more.empty()) {
    notes +=
        " CI: interval of the ratio. $r$: rank-biserial correlation. $p$: Wilcoxon's signed-rank test; $p_{H}$: with "
        "Holm's correction; $p_{S}$: over sequences.";
  }
  return float_of(
      rows, fmt::format("{}: {} against the baseline.", latex_escaped(study.name), latex_escaped(table.metric.title)),
      label_of(study, table, ":comparison"), notes);
}

}  // namespace

std::string to_latex(const StudyFolder& study, LatexRows rows) {
  std::string text = "% needs \\usepackage{booktabs}; table* spans both columns of a paper\n";
  if (study.methods.empty()) return text;
  for (const MetricTable& table : make_tables(study, study.metrics)) {
    text += metric_table(study, table, rows) + comparison_table(study, table);
  }
  return text;
}

}  // namespace aslio::report
