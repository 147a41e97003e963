/// What `aslio experiment` shows on a terminal.

#include <catch2/catch.hpp>

#include "aslio/study_display.hpp"

using aslio::cli::display_text;

TEST_CASE("the display of a study has its count, the time left, the failures and what is at work") {
  aslio::experiment::StudyProgress progress;
  progress.total = 8;
  progress.active = {{"q_1: simulation", 3.2}};
  CHECK(display_text(progress, 79) == "[>                       ] 0/8 runs\n     0:03  q_1: simulation");
  progress.done = 4;
  progress.failed = 1;
  progress.left_s = 3725;
  progress.active = {{"q_1/as_lio", 61}, {"q_1/fixed", 3600}};
  CHECK(display_text(progress, 79) ==
        "[============>           ] 4/8 runs   1:02:05 left   1 failed\n     1:01  q_1/as_lio\n  1:00:00  q_1/fixed");
  CHECK(display_text(progress, 12) == "[===========\n     1:01  q\n  1:00:00  q");
  progress.active.assign(20, {"q_1/as_lio", 1});
  CHECK(display_text(progress, 79).ends_with("q_1/as_lio\n           and 8 more"));
}
