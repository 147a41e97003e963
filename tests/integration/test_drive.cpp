// A simulated car that is under way from the first sample on: configs/scenes/drive_city.yaml, drive_highway.yaml.
#include <catch2/catch.hpp>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/simulation.hpp"
#include "integration/recorded_scene.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

struct Drive {
  Drive(const std::string& scene, const std::vector<std::string>& overrides, double duration, std::uint64_t seed = 111)
      : simulation(simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/" + scene + ".yaml", overrides),
                   {.seed = seed}),
        recording(record(simulation, duration)),
        truth(simulation.truth()) {}
  simulator::Simulation simulation;
  Recording recording;
  Trajectory truth;
};

}  // namespace

TEST_CASE("drive: a car in a city is followed from 8 m/s on, with and without adaptation") {
  const Drive drive("drive_city", {"lidar.columns=400"}, 10.0);
  for (const char* pipeline : {"as_lio_plus", "as_lio_plus_fast", "fixed_window"}) {
    Run run(shipped(pipeline), drive.simulation.claimed_sensor());
    run.play(drive.recording);
    const evaluation::Evaluation error = evaluation::evaluate(run.trajectory(), drive.truth);
    CAPTURE(pipeline, error.ate.translation.rmse);
    CHECK_FALSE(run.odometry.divergence());
    CHECK(run.odometry.losses().empty());
    CHECK(error.ate.translation.rmse < 0.1);
  }
}

TEST_CASE("drive: between guard rails at 30 m/s with an IMU of 10 Hz, a run is right or says that it is not") {
  const Drive drive("drive_highway", {"lidar.columns=400"}, 8.0);
  REQUIRE(drive.simulation.motion().at(0).v.norm() > 20.0);
  for (const char* pipeline : {"as_lio_plus", "fixed_window", "fast_lio2", "kiss_icp"}) {
    Run run(shipped(pipeline), drive.simulation.claimed_sensor());
    run.play(drive.recording);
    const bool silent = run.odometry.losses().empty() && !run.odometry.divergence() &&
                        run.odometry.tracking() == pipeline::TrackingStatus::ok && run.odometry.initialisation() &&
                        run.odometry.initialisation()->doubt.empty();
    CAPTURE(pipeline, run.updates.size());
    if (!silent) continue;
    const evaluation::Evaluation error = evaluation::evaluate(run.trajectory(), drive.truth);
    CHECK(error.ate.translation.rmse < 2.4);  // 1 % of 240 m
  }
}

TEST_CASE("drive: where a car brakes and turns, gravity and the bias of the accelerometer do not run away together") {
  const Drive drive("drive_city", {"lidar.columns=400"}, 16.0, 121);
  Run run(shipped("as_lio_plus"), drive.simulation.claimed_sensor());
  run.play(drive.recording);
  CHECK(run.odometry.losses().empty());
  const Vec3 b_a = run.updates.back().state.b_a;  // the true ones are within 0.1 m/s^2
  CAPTURE(b_a.transpose());
  CHECK(b_a.norm() < 0.4);  // eq. IESKF-14
}

TEST_CASE("drive: an IMU of 10 Hz is not believed to have read all that moves a car, so the points find its way") {
  const Drive drive("drive_highway", {"lidar.columns=400"}, 20.0, 121);
  Run run(shipped("as_lio_plus"), drive.simulation.claimed_sensor());
  run.play(drive.recording);
  CHECK(run.odometry.losses().empty());
  const double error = evaluation::evaluate(run.trajectory(), drive.truth).ate.translation.rmse;
  CAPTURE(error);
  CHECK(error < 1.0);  // eq. MOT-14; 3.7 m without it
}
