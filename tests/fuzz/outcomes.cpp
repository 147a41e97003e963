#include "aslio/experiment/calibrated_sensor.hpp"
#include "aslio/experiment/study_results.hpp"
#include "aslio/experiment/study_status.hpp"
#include "aslio/plugin/registry.hpp"
#include "fuzz/target.hpp"

// What a study reads back of its own: the plan, and the JSON files of one run.
ASLIO_FUZZ_TARGET(outcomes) {
  const auto& at = unpacked(bytes, {"plan.csv", "run_key.json", "summary.json", "manifest.json",
                                    "runs/a/b/run_key.json", "runs/a/b/summary.json"});
  accepts([&] { must(!experiment::to_text(experiment::read_status(at)).empty(), "a status has text"); });
  accepts([&] {
    const auto outcome = experiment::read_outcome(at, {});
    if (outcome) (void)experiment::read_row(at, *outcome);
    (void)experiment::read_summary_outcome(at);
  });
  accepts([&] {
    const plugin::Catalog none;
    const auto calibration = experiment::read_calibration(at, none);
    const auto combined = experiment::combine({calibration}, none);
    must(!combined.sensor_file.empty(), "a sensor file has text");
  });
}
