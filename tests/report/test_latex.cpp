/// The tables of a study as LaTeX.

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "aslio/core/length_unit.hpp"
#include "aslio/report/table.hpp"
#include "study_fixture.hpp"
#include "temporary_folder.hpp"

using namespace aslio::report;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

std::size_t count(const std::string& text, const std::string& words) {
  std::size_t found = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + words.size())) ++found;
  return found;
}

std::string latex_of_fixture(LatexRows rows) {
  const TemporaryFolder folder;
  write_study(folder.path());
  return to_latex(read_study_folder(folder.path()), rows);
}

/// A study of `methods` methods on one sequence with three recordings.
StudyFolder wide_study(std::size_t methods) {
  StudyFolder study;
  study.name = "a study & more";
  study.figures = study.metrics = {"ate_m"};
  study.sequences = {"indoor_1"};
  for (std::size_t m = 0; m < methods; ++m) {
    study.methods.push_back("method_" + std::to_string(m));
    for (const char* seed : {"1", "2", "3"}) {
      FolderRun run;
      run.data = std::string("indoor_1_") + seed;
      run.sequence = "indoor_1";
      run.method = study.methods.back();
      run.status = "ok";
      run.figures = {0.01 * static_cast<double>(m + 1)};
      study.runs.push_back(run);
    }
  }
  study.labels = study.methods;
  study.baseline.resize(methods);
  return study;
}

/// Every line of every tabular has as many cells as its columns.
void check_columns(const std::string& text) {
  std::istringstream lines(text);
  std::ptrdiff_t columns = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("\\begin{tabular}")) {
      columns = std::count(line.begin() + 15, line.end(), 'r') + std::count(line.begin() + 15, line.end(), 'l');
    }
    if (!line.ends_with("\\\\")) continue;
    INFO(line);
    CHECK(static_cast<std::ptrdiff_t>(count(line, " & ")) + 1 == columns);
  }
}

}  // namespace

TEST_CASE("LaTeX is booktabs with names escaped and labels in place of them") {
  const std::string text = latex_of_fixture(LatexRows::sequences);
  INFO(text);
  CHECK_THAT(text, Contains("\\toprule\nSequence & 10 Hz, fixed & as\\_lio\\_plus & <img src=x onerror=fail()>\\&\"' "
                            "\\\\\n\\midrule\n"));
  CHECK_THAT(text, Contains("loop & \\underline{55.0} {\\scriptsize(50.0--60.0)} & \\textbf{25.0}"));
  CHECK_THAT(text, Contains("$\\times$: total failure") && Contains("\\bottomrule"));
  check_columns(text);
}

TEST_CASE("every table in LaTeX has a label of its own") {
  const std::string text = latex_of_fixture(LatexRows::automatic);
  CHECK(count(text, "\\label{") == count(text, "\\caption{"));
  for (const char* label : {"tab:fixture:ate_m}", "tab:fixture:ate_m:comparison}", "tab:fixture:ate_deg}"}) {
    CHECK(count(text, label) == 1);
  }
}

TEST_CASE("methods are rows or columns of a table in LaTeX") {
  CHECK_THAT(latex_of_fixture(LatexRows::methods), Contains("Method & loop & turn \\\\\n"));
  // Three methods on two sequences: the fewer columns.
  CHECK(latex_of_fixture(LatexRows::automatic) == latex_of_fixture(LatexRows::methods));
  check_columns(latex_of_fixture(LatexRows::methods));
}

TEST_CASE("a table in LaTeX takes one column, both, or parts below each other") {
  CHECK_THAT(to_latex(wide_study(2), LatexRows::sequences), Contains("\\begin{table}[t]"));
  const std::string both = to_latex(wide_study(4), LatexRows::sequences);
  CHECK_THAT(both, Contains("\\begin{table*}[t]") && Contains("\\label{tab:a-study---more:ate_m}"));
  CHECK(count(both, "\\begin{tabular}") == 1);
  const std::string parts = to_latex(wide_study(12), LatexRows::sequences);
  CHECK(count(parts, "\\begin{tabular}") == 4);
  CHECK(count(parts, "method\\_11") == 1);
  CHECK_THAT(parts, !Contains("resizebox"));
  check_columns(parts);
  CHECK_THAT(to_latex(wide_study(12), LatexRows::methods), Contains("\\begin{table}[t]"));
}

TEST_CASE("one unit serves a table: millimetres below a tenth of a metre") {
  CHECK(aslio::length_unit(0.0999).name == "mm");
  CHECK(aslio::length_unit(0.1).name == "m");
  StudyFolder study = wide_study(12);
  CHECK(make_tables(study, {"ate_m"})[0].metric.unit == "m");  // up to 0.12
  study = wide_study(9);
  CHECK(make_tables(study, {"ate_m"})[0].metric.unit == "mm");
}
