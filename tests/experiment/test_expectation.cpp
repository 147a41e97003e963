/// `expectation`: what it may say, and what the runs say to it.

#include <catch2/catch.hpp>

#include "aslio/experiment/study_expectation.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace {

using Rows = std::vector<std::optional<StudyRow>>;

StudyRow row(double ate, const std::string& status = "ok") {
  return {.outcome = {.status = status, .reason = "", .wall_s = 1, .final = true}, .figures = {{"ate_m", ate}}};
}

/// Sequences a, b and c of two seeds, methods fixed and other, and one rule.
std::string text_of(const std::string& rule) {
  return head() + "expectation: [{" + rule +
         "}]\ndatasets:\n"
         "  - {scene: scene_a.yaml, seeds: 1-2, name: a}\n  - {scene: scene_b.yaml, seeds: 1-2, name: b}\n"
         "  - {scene: scene_b.yaml, seeds: 3-4, name: c}\nmethods:\n" +
         method("fixed", "fixed_window") + method("other", "as_lio_plus", "differs: [window, history]") +
         "baseline: fixed\n";
}

/// other is lower on a, higher on b, and lower on c where `c` is 0.1. Six pairs, of which it wins as many.
Rows rows_of(double c) {
  return {row(0.2), row(0.1), row(0.2), row(0.1), row(0.2), row(0.3),
          row(0.2), row(0.3), row(0.2), row(c),   row(0.2), row(c)};
}

struct Judged {
  StudyFiles files;
  JudgedRule operator()(const std::string& rule, const Rows& rows) const {
    const Study study = files.load(text_of(rule));
    const auto runs = plan_runs(study, "program");
    const StudyFigures figures(study, runs, rows);
    return judge_expectation(study, runs, rows, figures).at(0);
  }
};

}  // namespace

TEST_CASE("a rule holds, does not hold, or is not decided by the runs that are there") {
  const Judged judged;
  const std::string two = "method: other, against: fixed, lower_on: 2 of 3 sequences";
  const JudgedRule held = judged("claim: it pays, " + two, rows_of(0.1));
  CHECK(held.text == "it pays: ate_m of other below that of fixed on 2 of 3 sequences, needs 2");
  CHECK(held.verdict == Verdict::holds);
  CHECK(to_markdown(held).ends_with("needs 2: **holds**"));
  CHECK(judged(two, rows_of(0.3)).verdict == Verdict::does_not_hold);
  CHECK(judged("method: other, against: fixed, not_lower_on: 2 of 3 sequences", rows_of(0.3)).verdict ==
        Verdict::holds);
  CHECK(judged("method: other, against: fixed, not_lower_on: 2 of 3 sequences", rows_of(0.1)).verdict ==
        Verdict::does_not_hold);
  Rows rows = rows_of(0.1);
  rows[11].reset();  // c is open: one is won, one is lost
  const JudgedRule open = judged(two, rows);
  CHECK(open.verdict == Verdict::not_decided);
  CHECK(to_markdown(open).ends_with("**not decided** (1 of 3 sequences without all figures yet)"));
  rows[4] = row(9);  // b is won, too: c cannot change it
  rows[6] = row(9);
  CHECK(judged(two, rows).verdict == Verdict::holds);
  CHECK(judged("method: other, against: fixed, lower_on: 3 of 3 sequences", rows).verdict == Verdict::not_decided);
}

TEST_CASE("pairs, factors, sequences and failures in a rule") {
  const Judged judged;
  CHECK(judged("method: other, against: fixed, lower_on: most pairs", rows_of(0.1)).verdict == Verdict::holds);
  CHECK(judged("method: other, against: fixed, lower_on: 5 of 6 pairs", rows_of(0.1)).verdict ==
        Verdict::does_not_hold);
  // 0.1 is not below 0.4 times 0.2, and below 0.6 times.
  CHECK(judged("method: other, against: fixed, lower_on: 1 of 3 sequences, times: 0.4", rows_of(0.1)).verdict ==
        Verdict::does_not_hold);
  CHECK(judged("method: other, against: fixed, lower_on: 2 of 3 sequences, times: 0.6", rows_of(0.1)).verdict ==
        Verdict::holds);
  CHECK(judged("method: other, against: fixed, higher_on: 1 of 3 sequences, times: 1.4", rows_of(0.1)).verdict ==
        Verdict::holds);
  CHECK(judged("method: other, against: fixed, not_higher_on: 1 of 3 sequences, times: 1.6", rows_of(0.1)).verdict ==
        Verdict::holds);
  CHECK(judged("method: other, against: fixed, lower_on: 1 of 1 sequences, sequences: [b]", rows_of(0.1)).verdict ==
        Verdict::does_not_hold);
  // A failure is worse than any figure, and is counted.
  Rows rows = rows_of(0.1);
  rows[8] = row(0, "diverged");
  rows[10] = row(0, "crashed");
  CHECK(judged("method: other, against: fixed, lower_on: 1 of 1 sequences, sequences: [c]", rows).verdict ==
        Verdict::holds);
  CHECK(judged("method: fixed, failures: 1", rows).verdict == Verdict::does_not_hold);
  CHECK(judged("method: fixed, failures: 2", rows).verdict == Verdict::holds);
  CHECK(judged("method: other, failures: 0", rows).verdict == Verdict::holds);
  rows[1].reset();
  const JudgedRule open = judged("method: other, failures: 0", rows);
  CHECK(open.verdict == Verdict::not_decided);
  CHECK(open.open == "1 run is missing");
}

TEST_CASE("a failed run has no place among figures of which the smaller is no better") {
  const Judged judged;
  Rows rows = rows_of(0.1);
  for (auto& row : rows) row->figures.emplace_back("coverage", 0.9);
  for (const std::size_t i : {1, 3, 5, 7, 9, 11}) rows[i]->figures.back().second = 0.95;
  const std::string higher = "method: other, against: fixed, metric: coverage, higher_on: ";
  CHECK(judged(higher + "3 of 3 sequences", rows).verdict == Verdict::holds);
  for (const std::size_t i : {1, 3}) rows[i]->outcome.status = "diverged";
  CHECK(judged(higher + "3 of 3 sequences", rows).verdict == Verdict::not_decided);
  CHECK(judged(higher + "2 of 3 sequences", rows).verdict == Verdict::holds);
  CHECK(judged(higher + "5 of 6 pairs", rows).verdict == Verdict::not_decided);
  CHECK(judged("method: other, against: fixed, metric: coverage, not_lower_on: 1 of 3 sequences", rows).verdict ==
        Verdict::not_decided);
}

TEST_CASE("a pair of a rule is a recording, whatever the number of order seeds") {
  const StudyFiles files;
  const auto text = [](const std::string& count) {
    return head() + "expectation: [{claim: \"## two\\n\\n| lines\", method: b, against: a, lower_on: " + count +
           "}]\ndatasets: [{scene: scene_a.yaml, seeds: 1-2}]\norder_seeds: [0, 1, 2]\nmethods:\n" +
           method("a", "fixed_window") + method("b", "fixed_window", "set: {map.voxel: 0.7}");
  };
  CHECK_THAT(files.complaint(text("6 of 6 pairs")), Contains("there are 2 pairs"));
  const Study study = files.load(text("2 of 2 pairs"));
  const auto runs = plan_runs(study, "program");
  Rows rows = {row(0.2), row(0.1), row(0.2), row(0.3), row(0.2), row(0.1),
               row(0.2), row(0.1), row(0.2), row(0.1), row(0.2), row(0.3)};
  const auto judged = [&] { return judge_expectation(study, runs, rows, StudyFigures(study, runs, rows)).at(0); };
  CHECK(judged().verdict == Verdict::holds);
  // A claim of several lines stays one item of the list.
  CHECK(judged().text == "## two | lines: ate_m of b below that of a on 2 of 2 pairs, needs 2");
  rows[11].reset();
  CHECK(judged().verdict == Verdict::not_decided);
}

TEST_CASE("an expectation that cannot be judged is refused with its place") {
  const StudyFiles files;
  struct Case {
    std::string rule, complaint;
  };
  for (const Case& wrong : std::vector<Case>{
           {"method: other, against: fixed", "one is required"},
           {"method: other, against: fixed, lower_on: 2 of 3 sequences, failures: 0", "exclude each other"},
           {"against: fixed, lower_on: most pairs", "is required: name one of `methods`"},
           {"method: other, lower_on: most pairs", "is required: name the method to compare with"},
           {"method: othr, against: fixed, lower_on: most pairs", "no method is called 'othr'"},
           {"method: other, against: other, lower_on: most pairs", "against itself"},
           {"method: other, against: fixed, lower_on: 8 of 9 sequences", "there are 3 sequences"},
           {"method: other, against: fixed, lower_on: 8 of 9 pairs", "there are 6 pairs"},
           {"method: other, against: fixed, lower_on: 4 of 3 sequences", "must be as in"},
           {"method: other, against: fixed, lower_on: often", "must be as in"},
           {"method: other, against: fixed, lower_on: most pairs, metric: ate", "'ate' is none of ate_m"},
           {"method: other, against: fixed, lower_on: 1 of 1 sequences, sequences: [d]", "no sequence is called 'd'"},
           {"method: other, failures: 0.5", "must be a whole number"},
           {"method: other, against: fixed, lower_on: most pairs, when: now", "unknown key 'expectation.0.when'"}}) {
    const std::string complaint = files.complaint(text_of(wrong.rule));
    INFO(wrong.rule << "\n" << complaint);
    CHECK_THAT(complaint, Contains("study.yaml:5:") && Contains(wrong.complaint));
  }
  // Two methods that differ in what nobody names, though neither is the other's baseline.
  const std::string apart = head() +
                            "expectation: [{method: b, against: a, lower_on: most pairs}]\n"
                            "datasets: [{scene: scene_a.yaml}]\nmethods:\n" +
                            method("a", "fixed_window") + method("b", "as_lio_plus", "differs: [window]");
  CHECK_THAT(files.complaint(apart),
             Contains("study.yaml:5:") && Contains("add them to the `differs`") && Contains("history"));
}

TEST_CASE("the expectation stands in table.md") {
  const StudyFiles files;
  const Study study = files.load(text_of("method: other, against: fixed, lower_on: 2 of 3 sequences"));
  const std::string text = results_markdown(study, plan_runs(study, "program"), rows_of(0.1));
  CHECK_THAT(text, Contains("## Expectation\n\nAll in all: **holds**\n\n- ate_m of other below that of fixed"));
}
