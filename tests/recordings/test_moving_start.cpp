// A real car that is under way from the first sample on, with a calm IMU of 9.7 Hz: KITTI 0013.
#include <catch2/catch.hpp>

#include "recordings/recorded_run.hpp"
#include "shipped_names.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("moving start: as_lio_plus and its own kind follow a car at 11 m/s from wherever the data begin") {
  for (const char* pipeline : {"as_lio_plus", "as_lio_plus_fast", "fixed_window"}) {
    for (const double start_s : {0.0, 2.5}) {
      const RecordedRun run = run_on_moving_kitti(pipeline, start_s);
      CAPTURE(pipeline, start_s, run.summary.reason, run.summary.initialisation, run.ate_m());
      CHECK(run.summary.status == pipeline::RunStatus::ok);
      CHECK(run.ate_m() <= 0.35);
    }
  }
}

TEST_CASE("moving start: every shipped pipeline follows a car at 11 m/s, or says that it does not") {
  for (const std::string& pipeline : shipped_names()) {
    const RecordedRun run = run_on_moving_kitti(pipeline);
    CAPTURE(pipeline, run.summary.reason, run.ate_m());
    if (run.summary.status == pipeline::RunStatus::ok) CHECK(run.ate_m() <= 1.0);
  }
}
