// Runs that are wrong say so: data that are cut, an extrinsic that is wrong; and clean ones raise no alarm.
#include <catch2/catch.hpp>

#include "aslio/simulator/simulation.hpp"
#include "integration/recorded_scene.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

/// The recording without `length` after `begin`, and the stamps of what follows moved up.
Recording closed_up(const Recording& recording, TimeNs begin, TimeNs length) {
  Recording out;
  for (const Measurement& m : recording) {
    const auto* imu = std::get_if<ImuSample>(&m);
    const TimeNs t = imu != nullptr ? imu->t : std::get<LidarPacket>(m).stamp;
    if (t >= begin && t < begin + length) continue;
    out.push_back(m);
    if (t < begin) continue;
    if (auto* sample = std::get_if<ImuSample>(&out.back())) {
      sample->t -= length;
      continue;
    }
    auto& packet = std::get<LidarPacket>(out.back());
    packet.stamp -= length;
    for (TimedPoint& p : packet.points) p.t -= length;
  }
  return out;
}

struct Walk {
  simulator::Simulation simulation;
  Recording recording;
  explicit Walk(std::uint64_t seed)
      : simulation(simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml", {}), {.seed = seed}),
        recording(record(simulation, 16.0)) {}
  TimeNs at(double seconds) const { return std::get<ImuSample>(recording.front()).t + to_ns(seconds); }
};

}  // namespace

TEST_CASE("monitor: a walk raises no alarm, and 4 s cut out of it are a loss within a second, and a new segment") {
  for (const std::uint64_t seed : {101U, 102U}) {
    const Walk walk(seed);
    for (const char* name : {"as_lio_plus", "fast_lio2", "lio_sam"}) {
      CAPTURE(seed, name);
      Run clean(shipped(name), walk.simulation.claimed_sensor());
      clean.play(walk.recording);
      CHECK_FALSE(clean.odometry.divergence());
      CHECK(clean.odometry.monitor().alarms == 0);
      CHECK(clean.odometry.monitor().implausible.empty());

      Run cut(shipped(name), walk.simulation.claimed_sensor());
      cut.play(closed_up(walk.recording, walk.at(8.5), 4 * kSecond));
      REQUIRE(cut.odometry.divergence());
      CHECK(cut.odometry.divergence()->t > walk.at(8.5));
      CHECK(cut.odometry.divergence()->t < walk.at(9.5));
      CHECK(cut.odometry.divergence()->restarted);
      CHECK(cut.updates.back().segment >= 1);
      // Not merged. What left the window before (`on_exit`) may still enter with the update of the alarm.
      for (const auto& u : cut.updates) CHECK((!u.monitor.alarm || u.inserted.inserted < u.n_fresh));
    }
  }
}

TEST_CASE("monitor: an extrinsic that is wrong by a right angle or by a metre is named") {
  const Walk walk(101);
  SensorModel turned = walk.simulation.claimed_sensor();
  turned.T_imu_lidar.R = exp_so3(Vec3(0, 0, 1.5708)) * turned.T_imu_lidar.R;
  SensorModel moved = walk.simulation.claimed_sensor();
  moved.T_imu_lidar.p.x() += 1.0;
  for (const SensorModel& sensor : {turned, moved}) {
    Run run(shipped("as_lio_plus"), sensor);
    run.play(walk.recording);
    REQUIRE(run.odometry.divergence());
    CHECK_THAT(run.odometry.divergence()->reason, Contains("implausible") && Contains("check T_imu_lidar"));
    CHECK(run.odometry.divergence()->t < walk.at(7.0));  // it stands still for 1 s, and turns at 5 s
  }
}
