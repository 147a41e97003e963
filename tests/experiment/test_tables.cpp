/// results.csv and table.md from summaries made by hand.

#include <catch2/catch.hpp>

#include "aslio/experiment/study_results.hpp"
#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace {

using Rows = std::vector<std::optional<StudyRow>>;

StudyRow row(double ate, const std::string& status = "ok", const std::string& reason = "") {
  return {.outcome = {.status = status, .reason = reason, .wall_s = 1, .final = true}, .figures = {{"ate_m", ate}}};
}

/// Sequences a and b with seeds 1 to 3, methods fixed (the baseline) and other.
Study two_methods(const StudyFiles& files) {
  return files.load(head() +
                    "datasets:\n  - {scene: scene_a.yaml, seeds: 1-3, name: a}\n"
                    "  - {scene: scene_b.yaml, seeds: 1-3, name: b}\nmethods:\n" +
                    method("fixed", "fixed_window") + method("other", "as_lio_plus") +
                    "baseline: fixed\ndiffers: [window, history]\nmetrics: [ate_m, updates]\n");
}

}  // namespace

TEST_CASE("cells are medians over seeds, and a failure is worse than any figure") {
  const StudyFiles files;
  const Study study = two_methods(files);
  const auto runs = plan_runs(study, "program");
  const Rows rows = {row(0.3), row(0.1),                       // a_1
                     row(0.1), row(0.2),                       // a_2
                     row(0.2), row(9, "diverged", "far|off"),  // a_3
                     row(0.5), row(0, "failed", "lost"),       // b_1
                     row(0.5), row(0, "timeout", "longer"),    // b_2
                     row(0.5), std::nullopt};                  // b_3
  const std::string text = results_markdown(study, runs, rows);
  INFO(text);
  CHECK_THAT(text, Contains("**Question.** Which?") && Contains("11 of 12 runs."));
  CHECK_THAT(text, Contains("| sequence | fixed | other |\n|---|---|---|\n"
                            "| a | 0.2 (0.1-0.3) | 0.2 (0.1-0.2) 1- |\n"
                            "| b | 0.5 (0.5-0.5) | x 2x |\n"));
  // Sequences: a ties, b is lost. Pairs: a_1 won, a_2 and a_3 lost, b_1 and b_2 lost, b_3 not there.
  CHECK_THAT(text, Contains("| other | fixed | 0 / 1 / 1 | 1 / 4 / 0 |"));
  CHECK_THAT(text, Contains("| a_3 | other | diverged | far/off |") && Contains("| b_2 | other | timeout | longer |"));
  // A figure that no summary has; and who has more updates has not won anything.
  CHECK_THAT(text, Contains("## updates\n\n| sequence | fixed | other |\n|---|---|---|\n| a |  | - |"));
  CHECK(text.find("Won /", text.find("## updates")) == std::string::npos);
}

TEST_CASE("a run that failed before a tenth of the way is an x, a later one a dash") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 1-3, name: a}]\nmethods:\n" +
                                 method("one", "fixed_window") + "metrics: [ate_m, end_to_end_m]\n");
  const auto runs = plan_runs(study, "program");
  const auto run = [](const std::string& status, std::optional<double> failed_at) {
    StudyRow out = row(0.1, status);
    out.figures.emplace_back("end_to_end_m", 0.2);
    if (failed_at) out.figures.emplace_back("failed_at", *failed_at);
    return out;
  };
  const auto table = [&](const StudyRow& a, const StudyRow& b, const StudyRow& c) {
    return results_markdown(study, runs, {a, b, c});
  };
  const StudyRow good = run("ok", {}), soon = run("failed", 0.09), late = run("diverged", 0.1),
                 crashed = run("crashed", {});
  CHECK_THAT(table(good, soon, late), Contains("| a | x (0.1-0.1) 1x 1- |"));
  CHECK_THAT(table(good, late, late), Contains("| a | - (0.1-0.1) 2- |"));
  CHECK_THAT(table(good, good, crashed), Contains("| a | 0.1 (0.1-0.1) 1x |"));
  // Back at its beginning, but far away in between: no end-to-end error, and an ATE that shows it.
  const std::string back = table(good, good, run("ok", 0.5));
  CHECK_THAT(back, Contains("## ate_m\n\n| sequence | one |\n|---|---|\n| a | 0.1 (0.1-0.1) |"));
  CHECK_THAT(back, Contains("| a | 0.2 (0.2-0.2) 1- |") && Contains("no update was accepted for more than 1 s"));
}

TEST_CASE("two middle values of which one is a failure have no median") {
  const StudyFiles files;
  const Study study = two_methods(files);
  Rows rows(12);
  rows[1] = row(0.1);
  rows[3] = row(0.1, "crashed", "signal");
  CHECK_THAT(results_markdown(study, plan_runs(study, "program"), rows), Contains("| a |  | x (0.1-0.1) 1x |"));
}

TEST_CASE("results.csv has a line per run with all figures that any run has") {
  const StudyFiles files;
  const Study study = files.load(head() + "datasets: [{scene: scene_a.yaml, seeds: 4, name: a}]\nmethods:\n" +
                                 method("fixed", "fixed_window") +
                                 "vary: [{path: overlap.voxel, values: [0.1, 0.2]}]\norder_seeds: [0, 3]\n");
  Rows rows(4);
  rows[0] = row(0.25);
  rows[1] = row(0.5, "failed", "the \"map\", lost");
  rows[3] = row(1);
  rows[3]->figures.emplace_back("updates", 12);
  CHECK(results_csv(study, plan_runs(study, "program"), rows) ==
        "data,sequence,seed,order_seed,method,overlap.voxel,status,reason,ate_m,updates\n"
        "a_4,a,4,0,fixed_voxel_0.1,0.1,ok,,0.25,\n"
        "a_4,a,4,0,fixed_voxel_0.2,0.2,failed,\"the \"\"map\"\", lost\",0.5,\n"
        "a_4,a,4,3,fixed_voxel_0.2,0.2,ok,,1,12\n");
}

TEST_CASE("a row takes its figures from summary.json, and nothing from one that is no JSON") {
  const TemporaryFolder folder;
  write_text(folder / "summary.json",
             R"({"status": "degraded", "reason": "gap", "updates": 30, "weak_share": 0.5, "cpu_s": 2, "data_s": 8,
                 "rate_hz": {"min": 5, "median": 20, "max": 40}, "peak_rss_mb": 50, "coverage": 1,
                 "metrics": {"ate_m": 0.25, "rpe": null, "error": "text"}})");
  const auto outcome = read_summary_outcome(folder.path());
  REQUIRE(outcome.has_value());
  CHECK(outcome->status == "degraded");
  CHECK(outcome->reason == "gap");
  const StudyRow row = read_row(folder.path(), *outcome);
  CHECK(row.good());
  CHECK(row.figure("ate_m") == 0.25);
  CHECK_FALSE(row.figure("rpe").has_value());
  CHECK(row.figure("rate_hz") == 20);
  CHECK(row.figure("cpu_s_per_s") == 0.25);
  CHECK(row.figure("updates") == 30);
  for (const char* text : {"{\"status\": \"ok\"", "[]", "{}", ""}) {
    write_text(folder / "summary.json", text);
    INFO(text);
    CHECK_FALSE(read_summary_outcome(folder.path()).has_value());
    CHECK(read_row(folder.path(), {}).figures.empty());
  }
}

TEST_CASE("an outcome counts under its own key alone") {
  const TemporaryFolder folder;
  CHECK_FALSE(read_outcome(folder.path(), "key").has_value());
  write_outcome(folder.path(), "key", {.status = "failed", .reason = "why", .wall_s = 1.5, .final = true});
  CHECK_FALSE(read_outcome(folder.path(), "key").has_value());  // its summary is missing
  write_text(folder / "summary.json", "{}");
  const auto outcome = read_outcome(folder.path(), "key");
  REQUIRE(outcome.has_value());
  CHECK(outcome->status == "failed");
  CHECK(outcome->reason == "why");
  CHECK(outcome->wall_s == 1.5);
  CHECK(outcome->final);
  CHECK_FALSE(read_outcome(folder.path(), "other").has_value());
  write_text(folder / "run_key.json", content(folder / "run_key.json").substr(0, 40));
  CHECK_FALSE(read_outcome(folder.path(), "key").has_value());
}
