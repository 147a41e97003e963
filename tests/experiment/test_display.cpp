/// What `aslio experiment` shows on a terminal.

#include <catch2/catch.hpp>

#include "aslio/study_display.hpp"
#include "study_files.hpp"

using aslio::cli::display_text;

TEST_CASE("the display of a study has its count, the time left, the failures and what is at work") {
  aslio::experiment::StudyProgress progress;
  progress.total = 8;
  progress.active = {{"q_1: simulation", 3.2}};
  CHECK(display_text(progress, 79) == "[>                       ] 0/8 runs\n     0:03  q_1: simulation");
  progress.done = 4;
  progress.failed = 1;
  progress.left_s = 3725;
  progress.active = {{"q_1/as_lio_plus", 61}, {"q_1/fixed", 3600}};
  CHECK(display_text(progress, 79) ==
        "[============>           ] 4/8 runs   1:02:05 left   1 failed\n     1:01  q_1/as_lio_plus\n  1:00:00  "
        "q_1/fixed");
  CHECK(display_text(progress, 12) == "[===========\n     1:01  q\n  1:00:00  q");
  progress.active.assign(20, {"q_1/as_lio_plus", 1});
  CHECK(display_text(progress, 79).ends_with("q_1/as_lio_plus\n           and 8 more"));
}

TEST_CASE("the medians of a study are aligned, a method to a line, with the marks of failures") {
  using namespace aslio::experiment;
  const aslio::test::StudyFiles files;
  const Study study = files.load(aslio::test::head() +
                                 "datasets: [{scene: scene_a.yaml, seeds: 1-3}, {scene: scene_b.yaml}]\nmethods:\n" +
                                 aslio::test::method("one", "fixed_window") +
                                 aslio::test::method("another", "fixed_window") + "metrics: [ate_m]\n");
  const auto runs = plan_runs(study, "program");
  REQUIRE(runs.size() == 8);
  std::vector<std::optional<StudyRow>> rows(runs.size());
  const auto put = [&](const std::string& data, std::size_t method, const std::string& status, double ate) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (study.data[runs[i].data].name != data || runs[i].method != method) continue;
      StudyRow row;
      row.outcome.status = status;
      row.figures.emplace_back("ate_m", ate);
      rows[i] = row;
    }
  };
  put("scene_a_1", 0, "ok", 0.5);
  put("scene_a_2", 0, "ok", 0.25);
  put("scene_a_3", 0, "ok", 12.5);
  put("scene_a_1", 1, "crashed", 0);
  put("scene_b_1", 1, "diverged", 0);
  CHECK(aslio::cli::medians_text(study, runs, rows) ==
        "ate_m    scene_a  scene_b\n"
        "one          0.5         \n"
        "another        x        -\n");
}
