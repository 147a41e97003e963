// A recording that begins in full walk (eq. INI-3).
#include <catch2/catch.hpp>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/simulator/simulation.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// What a recording of the first `duration` seconds would hold: IMU samples, and each packet once it is complete.
Recording record(const simulator::Simulation& simulation, double duration) {
  Recording out;
  std::size_t sample = 0;
  const auto& imu = simulation.imu().samples;
  const auto imu_until = [&](TimeNs t) {
    for (; sample < imu.size() && imu[sample].t <= t; ++sample) out.push_back(imu[sample]);
  };
  const auto packets = static_cast<std::size_t>(to_ns(duration) / simulator::Simulation::kPacketPeriod);
  for (std::size_t i = 0; i < std::min(packets, simulation.packet_count()); ++i) {
    LidarPacket packet = simulation.packet(i).packet;
    imu_until(packet.stamp + simulator::Simulation::kPacketPeriod);
    out.push_back(std::move(packet));
  }
  return out;
}

}  // namespace

TEST_CASE("dynamic start: a scene that begins in full walk converges, for every seed and both pipelines") {
  const simulator::SceneFile scene =
      simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml", {"walk.dynamic_start=true"});
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const simulator::Simulation simulation(scene, {.seed = seed});
    const Recording recording = record(simulation, 10.0);
    const Trajectory truth = simulation.truth();
    REQUIRE(simulation.motion().at(0).v.norm() > 1.0);
    for (const char* pipeline : {"as_lio", "fixed_window"}) {
      Run run(shipped(pipeline), simulation.claimed_sensor());
      run.play(recording);
      REQUIRE(run.odometry.initialisation());
      const pipeline::Initialisation& found = *run.odometry.initialisation();
      const evaluation::Evaluation error = evaluation::evaluate(run.trajectory(), truth);
      CAPTURE(seed, pipeline, found.verdict, error.ate.translation.rmse, error.end_to_end.error);
      CHECK(found.initial.mode == InitialMode::dynamic_start);
      CHECK_FALSE(run.odometry.divergence());
      CHECK(run.odometry.tracking() == pipeline::TrackingStatus::ok);
      CHECK(error.ate.translation.rmse < 0.1);
    }
  }
}
