/// Equal tuning: candidates, the best one, and the pipeline file that comes of it.

#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "cli/recordings.hpp"
#include "study_files.hpp"
#include "study_tune.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

const std::string kTwoScenes = "datasets: [{scene: scene_a.yaml, seeds: 1-2}, {scene: scene_b.yaml, seeds: 7}]\n";

std::string space(const std::string& entries, int budget) {
  return "tune: {budget: " + std::to_string(budget) + ", seed: 3, space: [" + entries + "]}\n";
}

/// A row with this figure; none: a failure.
StudyRow row(std::optional<double> ate) {
  StudyRow out;
  out.outcome.status = ate ? "ok" : "diverged";
  out.outcome.final = true;
  if (ate) out.figures.emplace_back("ate_m", *ate);
  return out;
}

}  // namespace

TEST_CASE("tune: each pipeline gets as many candidates as the budget allows, the first one as it is written") {
  const StudyFiles files;
  const std::string text = head() + kTwoScenes + "methods:\n" + method("a", "fixed_window") + method("b", "fast_lio2");
  const Study study = files.load(
      text + space("{path: estimator.sigma, range: [0.01, 0.1], scale: log}, {path: map.leaf, range: [0.1, 0.6], "
                   "methods: [b]}, {path: window.period, values: [0.05, 0.1], methods: [a]}",
                   13));
  REQUIRE(study.methods.size() == 8);  // four candidates of three runs
  CHECK(study.axes == std::vector<std::string>{"candidate"});
  CHECK(study.methods[0].name == "a");
  CHECK(study.methods[0].set.empty());
  CHECK(study.methods[1].name == "a_t001");
  CHECK(study.methods[7].name == "b_t003");
  CHECK(study.methods[7].base == "b");
  // What both have is drawn alike, so that they are compared at the same places.
  CHECK(study.methods[1].set.at(0) == study.methods[5].set.at(0));
  CHECK_THAT(study.methods[1].set.at(0), Contains("estimator.sigma=0.0"));
  CHECK_THAT(study.methods[5].set.at(1), Contains("map.leaf=0."));
  CHECK_THAT(study.methods[1].set.at(1), Contains("window.period="));
  for (std::size_t m = 1; m < 4; ++m) {
    const double sigma = std::stod(study.methods[m].set.at(0).substr(16));
    CHECK(sigma >= 0.01);
    CHECK(sigma <= 0.1);
  }
  // Another seed draws other values, the same one the same.
  const auto first = [&](int seed) {
    const std::string tune =
        "tune: {budget: 6, seed: " + std::to_string(seed) + ", space: [{path: estimator.sigma, range: [0.01, 0.1]}]}\n";
    return files.load(text + tune).methods[1].set.at(0);
  };
  CHECK(first(3) == first(3));
  CHECK(first(3) != first(4));
}

TEST_CASE("tune: what is wrong with a space is reported with its place") {
  const StudyFiles files;
  const std::string text = head() + kTwoScenes + "methods:\n" + method("a", "fixed_window") + method("b", "fast_lio2");
  const auto complaint = [&](const std::string& entries, int budget = 12) {
    return files.complaint(text + space(entries, budget));
  };
  CHECK(complaint("{path: estimator.sigma, range: [0.01, 0.1]}").empty());
  CHECK_THAT(complaint("{path: estimator.sigma, range: [0.1, 0.01]}"),
             Contains("study.yaml:") && Contains("lower one first"));
  CHECK_THAT(complaint("{path: estimator.sigma}"), Contains("or `values` is required"));
  CHECK_THAT(complaint("{path: estimator.sigma, range: [0, 1], scale: log}"), Contains("above 0"));
  CHECK_THAT(complaint("{path: estimator.sigma, range: [0.01, 0.1], methods: [a]}"),
             Contains("'b' has no parameter in `tune.space`"));
  CHECK_THAT(complaint("{path: estimator.sigma, range: [0.01, 0.1]}, {path: map.leaf, range: [0.1, 1], methods: [c]}"),
             Contains("'c' is no method"));
  CHECK_THAT(
      complaint("{path: estimator.sigma, range: [0.01, 0.1]}, {path: estimator.sigma, range: [1, 2], methods: [b]}"),
      Contains("twice for 'b'"));
  CHECK_THAT(complaint("{path: estimator.max_iterations, range: [1.5, 4], whole: true}"), Contains("whole numbers"));
  CHECK_THAT(files.complaint(text + "vary: [{path: window.period, values: [0.1], methods: [a]}]\n" +
                             space("{path: estimator.sigma, range: [0.01, 0.1]}", 12)),
             Contains("exclude each other"));
  CHECK_THAT(complaint("{path: estimator.sigma, range: [0.01, 0.1]}", 5),
             Contains("not enough for two candidates over 3"));
  CHECK_THAT(complaint("{path: estimator.sgima, range: [0.01, 0.1]}"), Contains("sgima") && Contains("a_t001"));
}

TEST_CASE("tune: fewer failures win, then the smaller geometric mean, and an unfinished method has no winner") {
  const StudyFiles files;
  const Study study = files.load(head() + kTwoScenes + "methods:\n" + method("a", "fixed_window") +
                                 space("{path: estimator.sigma, range: [0.01, 0.1]}", 9));
  const std::vector<StudyRun> runs = plan_runs(study, "p");
  REQUIRE(runs.size() == 9);
  // By recording: untuned, first, second candidate.
  const std::vector<std::optional<double>> figures = {0.2, 0.001, 0.1, 0.2, std::nullopt, 0.2, 0.2, 0.001, 0.2};
  std::vector<std::optional<StudyRow>> rows;
  for (const auto& figure : figures) rows.emplace_back(row(figure));
  const auto best = best_candidates(study, runs, rows);
  REQUIRE(best.size() == 1);
  CHECK(study.methods[best[0].method].name == "a_t002");
  CHECK(best[0].failures == 0);
  CHECK(best[0].objective == Approx(std::cbrt(0.1 * 0.2 * 0.2)));
  CHECK(best[0].untuned_objective.value() == Approx(0.2));

  TemporaryFolder out;
  write_tuning(study, runs, rows, out.path());
  const std::string written = content(out / "tuned/a.yaml");
  CHECK_THAT(written,
             Contains("candidate 2 of 3") && Contains("# tuned-on scene_a_1 ") && Contains("schema: aslio/pipeline/1"));
  CHECK(line_count(out / "tuning.csv") == 4);
  // It is a pipeline, and none for what it was tuned on.
  const auto reports = [&](const std::string& seeds) {
    return files.complaint(head() + "datasets: [{scene: scene_a.yaml, seeds: '" + seeds +
                           "'}]\nmethods: [{name: t, pipeline: " + (out / "tuned/a.yaml").string() + "}]\n");
  };
  CHECK(reports("3-4").empty());
  CHECK_THAT(reports("2-3"), Contains("was tuned on scene_a_2") && Contains("other recordings"));

  rows[8].reset();
  CHECK(best_candidates(study, runs, rows).empty());
  write_tuning(study, runs, rows, out.path());
  CHECK_FALSE(fs::exists(out / "tuned/a.yaml"));
  for (auto& lost : rows) lost = row(std::nullopt);
  CHECK(best_candidates(study, runs, rows).empty());
}

TEST_CASE("tune: a study runs to pipelines that can be run") {
  TemporaryFolder folder;
  write_small_scene(folder);
  write_text(folder / "study.yaml", head() + "datasets: [{scene: small.yaml, seeds: 1-2, name: q}]\nmethods:\n" +
                                        method("fixed", "fixed_window") +
                                        space("{path: estimator.sigma, range: [0.01, 0.1], scale: log}", 4));
  const Ended ended = run_aslio({"experiment", folder / "study.yaml", "--output", folder / "out", "--quiet"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK(run_aslio({"check", folder / "out/tuned/fixed.yaml"}).code == 0);
  CHECK(column(folder / "out/results.csv", "candidate") == std::vector<std::string>{"0", "1", "0", "1"});
  CHECK(run_aslio({"report", folder / "out", "--format", "md,csv"}).code == 0);
}
