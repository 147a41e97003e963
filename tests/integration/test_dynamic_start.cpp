// A recording that begins in full walk (eq. INI-6).
#include <catch2/catch.hpp>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/simulation.hpp"
#include "integration/recorded_scene.hpp"

using namespace aslio;
using namespace aslio::test;

TEST_CASE("dynamic start: a scene that begins in full walk converges, for every seed and both pipelines") {
  const simulator::SceneFile scene =
      simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml", {"walk.dynamic_start=true"});
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const simulator::Simulation simulation(scene, {.seed = seed});
    const Recording recording = record(simulation, 10.0);
    const Trajectory truth = simulation.truth();
    REQUIRE(simulation.motion().at(0).v.norm() > 1.0);
    for (const char* pipeline : {"as_lio_plus", "fixed_window"}) {
      Run run(shipped(pipeline), simulation.claimed_sensor());
      run.play(recording);
      REQUIRE(run.odometry.initialisation());
      const pipeline::Initialisation& found = *run.odometry.initialisation();
      const evaluation::Evaluation error = evaluation::evaluate(run.trajectory(), truth);
      CAPTURE(seed, pipeline, found.verdict, error.ate.translation.rmse, error.end_to_end.error);
      CHECK(found.initial.mode == InitialMode::moving_start);
      CHECK_FALSE(run.odometry.divergence());
      CHECK(run.odometry.tracking() == pipeline::TrackingStatus::ok);
      CHECK(error.ate.translation.rmse < 0.02);
    }
  }
}
