/// What a study says of its doubt: statistics.csv, the comparison in table.md, variants that do not differ.

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "aslio/experiment/study_statistics.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace {

using Rows = std::vector<std::optional<StudyRow>>;

StudyRow row(double ate, const std::string& status = "ok") {
  return {.outcome = {.status = status, .reason = "", .wall_s = 1, .final = true},
          .figures = {{"ate_m", ate}, {"cpu_s_per_s", 0.1}}};
}

/// Two sequences of four seeds, methods fixed (the baseline), other and third.
struct Fixture {
  StudyFiles files;
  Study study = files.load(head() +
                           "datasets:\n  - {scene: scene_a.yaml, seeds: 1-4, name: a}\n"
                           "  - {scene: scene_b.yaml, seeds: 1-4, name: b}\nmethods:\n" +
                           method("fixed", "fixed_window") + method("other", "as_lio_plus") +
                           method("third", "as_lio_plus", "set: {window.seg_step: 0.2}") +
                           "baseline: fixed\ndiffers: [window, history]\nmetrics: [ate_m]\n");
  std::vector<StudyRun> runs = plan_runs(study, "program");
  Rows rows;

  /// other is better by a ratio of its own in each pair, third worse by a factor of two.
  Fixture() {
    for (int k = 0; k < 8; ++k) {
      const double base = k < 4 ? 0.1 + 0.01 * k : 2.0 + 0.1 * k;
      rows.insert(rows.end(), {row(base), row(base * (0.5 + 0.05 * k)), row(2 * base + 0.001 * k)});
    }
  }
  Comparison compared(std::size_t which) const { return StudyFigures(study, runs, rows).comparisons("ate_m")[which]; }
};

}  // namespace

TEST_CASE("a comparison tells ratio, interval, effect and corrected p over all pairs") {
  const Fixture f;
  const Comparison other = f.compared(0), third = f.compared(1);
  CHECK(other.method == 1);
  CHECK(other.baseline == 0);
  CHECK(other.pairs.won == 8);
  CHECK(other.sequences.won == 2);
  CHECK(*other.ratio == Approx(0.675));
  REQUIRE(other.interval.has_value());
  CHECK(other.interval->low >= 0.5);
  CHECK(other.interval->low < 0.6);
  CHECK(other.interval->high > 0.75);
  CHECK(*other.effect == -1);
  CHECK(*other.p == Approx(2 / 256.0));
  CHECK(*other.p_holm == Approx(4 / 256.0));
  CHECK(*third.effect == 1);
  CHECK(third.pairs.lost == 8);
  CHECK_THAT(results_markdown(f.study, f.runs, f.rows), Contains("| other | fixed | 2 / 0 / 0 | 8 / 0 / 0 | 0.675 (") &&
                                                            Contains(" | -1.00 | 0.008 | 0.016 | - |"));
}

TEST_CASE("a failure counts against its method with the largest difference there is") {
  Fixture f;
  f.rows[1] = row(0, "crashed");
  f.rows[12] = row(0, "timeout");  // of the baseline
  f.rows[13] = row(0, "failed");   // in the same pair
  const Comparison other = f.compared(0);
  CHECK(other.failed == 2);
  CHECK(other.baseline_failed == 1);
  CHECK(other.pairs.won == 6);
  CHECK(other.pairs.lost == 1);
  CHECK(other.pairs.tied == 1);
  CHECK(*other.effect == Approx((7.0 - 21.0) / 28.0));
  // Fewer than six pairs: wins and losses alone.
  for (std::size_t i = 9; i < f.rows.size(); ++i) f.rows[i].reset();
  const Comparison few = f.compared(1);
  CHECK(few.pairs.lost == 3);
  CHECK_FALSE(few.p.has_value());
  CHECK_FALSE(few.p_holm.has_value());
  CHECK_FALSE(few.interval.has_value());
  CHECK_THAT(results_markdown(f.study, f.runs, f.rows), Contains(" | - | - |"));
}

TEST_CASE("statistics.csv has a line per sequence and method, and per comparison") {
  const Fixture f;
  write_text(f.files.folder / "statistics.csv", statistics_csv(f.study, StudyFigures(f.study, f.runs, f.rows)));
  const auto of = [&](const char* name) { return column(f.files.folder / "statistics.csv", name); };
  CHECK(of("sequence") == std::vector<std::string>{"a", "a", "a", "b", "b", "b", "", ""});
  CHECK(of("method") ==
        std::vector<std::string>{"fixed", "other", "third", "fixed", "other", "third", "other", "third"});
  CHECK(of("baseline") == std::vector<std::string>{"", "", "", "", "", "", "fixed", "fixed"});
  CHECK(of("runs") == std::vector<std::string>{"4", "4", "4", "4", "4", "4", "8", "8"});
  CHECK(std::stod(of("quartile_1")[0]) == Approx(0.1075));
  CHECK(of("low")[0].empty());  // of four values
  CHECK_FALSE(of("low")[6].empty());
  CHECK(of("p")[6] == "0.0078125");
  const std::string text = content(f.files.folder / "statistics.csv");
  CHECK_THAT(text, Contains(",-1,0.0078125,0.015625,\n"));
  // As many cells in every line.
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    INFO(line);
    CHECK(std::count(line.begin(), line.end(), ',') == 21);
  }
  CHECK(of("pairs_lost")[7] == "8");
}

TEST_CASE("sequences are compared over the recordings that both have, and have a test of their own") {
  Fixture f;
  // Of other, which is lower everywhere, the baseline has one recording of b left: other's own others are worse.
  for (std::size_t i = 15; i < f.rows.size(); i += 3) {
    f.rows[i].reset();
    f.rows[i + 1] = row(90);
  }
  CHECK(f.compared(0).sequences.won == 2);
  CHECK_FALSE(f.compared(0).p_sequences.has_value());
  // Six sequences of three seeds each: the pairs look like eighteen, and only six worlds were seen.
  const StudyFiles files;
  std::string datasets = "datasets:\n";
  for (int s = 0; s < 6; ++s) datasets += "  - {scene: scene_a.yaml, seeds: 1-3, name: w" + std::to_string(s) + "}\n";
  const Study study =
      files.load(head() + datasets + "methods:\n" + method("fixed", "fixed_window") +
                 method("other", "as_lio_plus", "differs: [window, history]") + "baseline: fixed\nmetrics: [ate_m]\n");
  const auto runs = plan_runs(study, "program");
  Rows rows;
  for (int k = 0; k < 18; ++k) rows.insert(rows.end(), {row(1), row(k / 3 == 5 ? 1.1 : 0.5 + 0.01 * k)});
  const Comparison c = StudyFigures(study, runs, rows).comparisons("ate_m").at(0);
  CHECK(*c.p < 0.01);
  CHECK(*c.p_sequences == 4 / 64.0);  // one of six has the smallest rank and the other sign
}

TEST_CASE("order seeds are no further pairs: the median over them stands for the recording") {
  const StudyFiles files;
  const Study study =
      files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 1-2, name: a}]\norder_seeds: [0, 1, 2]\nmethods:\n" +
                 method("fixed", "fixed_window") + method("other", "as_lio_plus", "differs: [window, history]") +
                 "baseline: fixed\nmetrics: [ate_m]\n");
  const auto runs = plan_runs(study, "program");
  // By recording and order seed: fixed, other. `other` is lower twice on the first one, once on the second.
  Rows rows = {row(0.2), row(0.1), row(0.2), row(0.1), row(0.2), row(0.5),
               row(0.4), row(0.3), row(0.4), row(0.8), row(0.4), row(0, "diverged")};
  const StudyFigures figures(study, runs, rows);
  const Comparison c = figures.comparisons("ate_m").at(0);
  CHECK(c.pairs.won == 1);
  CHECK(c.pairs.lost == 1);
  CHECK(*c.ratio == Approx((0.5 + 2) / 2));
  CHECK_FALSE(c.p.has_value());
  CHECK(c.failed == 0);
  const Replicates other = figures.replicates(0, 1, "ate_m");
  CHECK(other.values == std::vector<double>{0.1, 0.8});
  CHECK(other.runs == 6);
  CHECK(other.failed == 1);
  const std::string text = results_markdown(study, runs, rows);
  CHECK_THAT(text, Contains("| a | 0.3 (0.2-0.4) | 0.45 (0.1-0.8) 1- |") || Contains("0.45 (0.1-0.8) 1x |"));
  // The same for every order seed, on all recordings: no replicates, and told.
  CHECK_THAT(text,
             Contains("## Identical results") && Contains("- fixed gave the same figures to the last bit for every "
                                                          "order seed, on 2 recordings: the order seed"));
  CHECK_THAT(text, !Contains("other gave the same"));
  // A pair with an order seed that is missing on one side is taken over the others.
  rows[5].reset();
  CHECK(*StudyFigures(study, runs, rows).pair(0, 1, 0, "ate_m").value == 0.1);
  CHECK(StudyFigures(study, runs, rows).pair(0, 1, 0, "ate_m").seeds == 2);
}

TEST_CASE("methods whose runs do not differ in a bit are told, whatever the clock said") {
  Fixture f;
  CHECK(identical_methods(f.study, f.runs, f.rows).empty());
  for (std::size_t i = 0; i < f.rows.size(); i += 3) {
    f.rows[i + 2] = f.rows[i + 1];
    f.rows[i + 2]->figures[1].second = 0.3;
  }
  f.rows[0] = row(0, "failed");  // says nothing about equality
  const auto same = identical_methods(f.study, f.runs, f.rows);
  REQUIRE(same.size() == 1);
  CHECK(same[0].first == 1);
  CHECK(same[0].second == 2);
  CHECK(same[0].runs == 8);
  CHECK_THAT(
      results_markdown(f.study, f.runs, f.rows),
      Contains("## Identical results\n\n- other and third gave the same figures to the last bit in all 8 pairs"));
  f.rows[5]->figures[0].second += 1e-15;
  CHECK(identical_methods(f.study, f.runs, f.rows).empty());
}
