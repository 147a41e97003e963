/// The shipped scenes of a car, and what a scene file may say of one.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/simulation.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;

namespace {

SceneFile shipped(const std::string& name, const std::vector<std::string>& changes = {}) {
  return load_scene(ASLIO_SOURCE_DIR "/configs/scenes/" + name + ".yaml", changes);
}

struct Speeds {
  double start = 0, lowest = 1e9, highest = 0, across = 0;
};
Speeds speeds_of(const Simulation& simulation) {
  Speeds s{simulation.motion().at(0).v.head<2>().norm()};
  for (double t = 0; t < simulation.duration(); t += 0.05) {
    const MotionState m = simulation.motion().at(t);
    s.lowest = std::min(s.lowest, m.v.head<2>().norm());
    s.highest = std::max(s.highest, m.v.head<2>().norm());
    s.across = std::max(s.across, std::abs((m.R.transpose() * m.a).y()));
  }
  return s;
}

}  // namespace

TEST_CASE("the city drive starts at 8 m/s, stops, and has 100 IMU samples per second", "[drive]") {
  const SceneFile file = shipped("drive_city");
  const Simulation simulation(file, {});
  const Speeds speeds = speeds_of(simulation);
  CHECK(speeds.start == Approx(8));
  CHECK(speeds.lowest < 1e-9);
  CHECK(speeds.highest > 12);
  CHECK(speeds.highest < 14.01);
  CHECK(speeds.across < 3.6);
  CHECK(file.scene.imu.rate == 100);
  CHECK(simulation.duration() > 60);
  CHECK(simulation.duration() < 120);
  const Simulation standing(shipped("drive_city", {"drive.start_speed=0"}), {});
  CHECK(standing.motion().at(1).v.norm() == 0);
}

TEST_CASE("the motorway drive stays between 24 and 33 m/s and has 10 IMU samples per second", "[drive]") {
  const SceneFile file = shipped("drive_highway");
  const Simulation simulation(file, {});
  const Speeds speeds = speeds_of(simulation);
  CHECK(speeds.start == Approx(28).margin(0.01));
  CHECK(speeds.lowest > 24.9);
  CHECK(speeds.highest > 30);
  CHECK(speeds.highest < 33.1);
  CHECK(simulation.imu().samples.size() == static_cast<std::size_t>(simulation.duration() * 10) + 1);
  CHECK(simulation.duration() > 30);
}

TEST_CASE("packets of a drive hold what a spinning sensor of that many columns sees", "[drive]") {
  for (const char* name : {"drive_city", "drive_highway"}) {
    CAPTURE(name);
    const Simulation simulation(shipped(name, {"lidar.columns=400", "drive.duration=12"}), {});
    const SimulatedPacket packet = simulation.packet(50);
    CHECK(packet.rays == 64 * 400);
    CHECK(packet.blocks.size() == 10);
    CHECK(packet.packet.points.size() > 10'000);
    std::size_t on_cars = 0;
    for (std::size_t k = 0; k < simulation.packet_count(); k += 10)
      for (const CellBlock& block : simulation.packet(k).blocks) on_cars += block.people_rays;
    CHECK(on_cars > 500);
  }
}

TEST_CASE("what does not go together in a scene with a drive is refused", "[drive]") {
  const aslio::test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& yaml) -> std::string {
    try {
      const Simulation simulation(load_scene(folder.write("s.yaml", "schema: aslio/scene/1\n" + yaml)), {});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string route = "route: [{x: 0, y: 0}, {x: 200, y: 0}]\n", street = "world: {type: street}\n";
  CHECK_THAT(refusal(route + "motion: drive\n"), Contains("street or mesh"));
  CHECK_THAT(refusal(route + street), Contains("motion: drive"));
  CHECK_THAT(refusal(route + street + "motion: drive\nwalk: {speed: 1}\n"), Contains("walk"));
  CHECK_THAT(refusal(route + street + "motion: drive\ndrive: {start_speed: 20}\n"), Contains("start_speed"));
  CHECK_THAT(refusal(route + street + "motion: drive\nlidar: {columns: 900}\n"), Contains("columns"));
  CHECK_THAT(refusal(route + street + "motion: drive\ncars: {beside: 1}\n"), Contains("cars.beside"));
}
