#pragma once
/// What the tables as Markdown and as LaTeX share.

#include <string>
#include <string_view>

#include "aslio/report/encode.hpp"
#include "aslio/report/table.hpp"

namespace aslio::report {

/// How a kind of text is marked up.
struct Markup {
  std::string (*escaped)(std::string_view);
  std::string_view best_begin, best_end, second_begin, second_end, range_begin, range_dash, range_end, diverged, failed,
      times;
};

inline constexpr Markup kMarkdown = {&markdown_cell, "**", "**", "<u>", "</u>", " (", "-", ")", "-", "x", "x"};
inline constexpr Markup kLatex = {&latex_escaped, "\\textbf{", "}",  "\\underline{", "}",        " {\\scriptsize(",
                                  "--",           ")}",        "--", "$\\times$",    "$\\times$"};

/// "1.2 (1.0-1.5) 1x 2-": median, range of the recordings with a figure, how many runs failed and diverged.
std::string cell_text(const Metric& metric, const Cell& cell, const Markup& markup);
/// "ATE [mm]".
std::string heading(const Metric& metric);
/// What the marks of this table mean; only those that are in it.
std::string footnotes(const MetricTable& table, const Markup& markup);
/// "won / lost / tied".
std::string tally_text(const Tally& tally);
std::string ratio_text(const Comparison& comparison, const Markup& markup);

}  // namespace aslio::report
