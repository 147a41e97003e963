/// What every scene under configs/scenes must hold: it loads, closes its loop, turns as sharply as it says, and is cast
/// fast enough.

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/simulator/simulation.hpp"
#include "simulator/box_room.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

std::vector<std::filesystem::path> scene_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(ASLIO_SOURCE_DIR "/configs/scenes"))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

bool driven(const std::filesystem::path& file) { return load_scene(file).scene.motion == MotionKind::drive; }

/// Every ray ends on something.
bool under_a_roof(const std::filesystem::path& file) {
  const WorldKind type = load_scene(file).scene.world.type;
  return !driven(file) && type != WorldKind::campus && type != WorldKind::old_town && type != WorldKind::forest;
}

}  // namespace

TEST_CASE("the scenes of the paper and the others are there", "[scenes]") {
  std::vector<std::string> names;
  for (const auto& file : scene_files()) names.push_back(file.stem().string());
  for (const char* name :
       {"indoor_1", "indoor_2", "indoor_3", "outdoor_1", "outdoor_2", "outdoor_3", "outdoor_4", "outdoor_5",
        "outdoor_6", "garage_degenerate", "doorway_360", "quickstart", "drive_city", "drive_highway", "stairwell"}) {
    CAPTURE(name);
    CHECK(std::count(names.begin(), names.end(), name) == 1);
  }
}

TEST_CASE("every scene that is walked returns to its start", "[scenes]") {
  for (const auto& file : scene_files()) {
    if (driven(file)) continue;
    const SceneFile scene = load_scene(file);
    for (const double scale : {0.2, 1.0}) {
      if (scale != 1 && scene.scene.world.type == WorldKind::stairwell) continue;  // steps do not scale
      CAPTURE(file.stem().string(), scale);
      const Simulation simulation(scene, {.scale = scale});
      const MotionState begin = simulation.motion().at(0), end = simulation.motion().at(simulation.duration());
      CHECK((begin.p - end.p).norm() < 1e-9);
      CHECK((begin.R - end.R).cwiseAbs().maxCoeff() < 1e-9);
      const Trajectory truth = simulation.truth();
      CHECK(truth.path_length() > 0.8 * simulation.route()->length() * static_cast<double>(scene.scene.walk.laps));
      CHECK(truth.path_length() < 1.2 * simulation.route()->length() * static_cast<double>(scene.scene.walk.laps));
    }
  }
}

TEST_CASE("every scene that is walked has sharp turns of 180 to 450 degrees per second", "[scenes]") {
  for (const auto& file : scene_files()) {
    if (driven(file)) continue;
    CAPTURE(file.stem().string());
    const Simulation simulation(load_scene(file), {});
    double peak = 0;
    for (double t = 0; t < simulation.duration(); t += 0.005) {
      const MotionState m = simulation.motion().at(t);
      peak = std::max(peak, std::abs((m.R * m.w).z()) * 180 / M_PI);
    }
    CHECK(peak > 180);
    CHECK(peak < 460);
  }
}

TEST_CASE("every scene surrounds the sensor with returns", "[scenes]") {
  for (const auto& file : scene_files()) {
    CAPTURE(file.stem().string());
    const Simulation simulation(load_scene(file), {});
    const bool indoors = under_a_roof(file);
    for (std::size_t index = 0; index < simulation.packet_count(); index += 1 + simulation.packet_count() / 15) {
      const SimulatedPacket packet = simulation.packet(index);
      CAPTURE(index);
      std::size_t met = 0;
      for (const CellBlock& block : packet.blocks) met += block.cells.size() + block.people_rays;
      // Indoors there is always a wall; what does not return was lost to the model: far floors and walls of long views.
      const auto rays = static_cast<double>(packet.rays);
      CHECK(static_cast<double>(met) > (indoors ? 0.99 : 0.4) * rays);
      CHECK(static_cast<double>(packet.packet.points.size()) > (indoors ? 0.6 : 0.25) * rays);
    }
  }
}

namespace {

struct CastCost {
  double rays_per_s = 0;  ///< of CPU time, so that other work on the machine counts little
  double times_real = 0;  ///< data time over CPU time
};

/// About a dozen packets, spread over the walk.
CastCost cost_of(const Simulation& simulation) {
  double cpu = 0;
  std::size_t rays = 0, packets = 0;
  for (std::size_t index = 0; index < simulation.packet_count();
       index += 1 + simulation.packet_count() / 12, ++packets) {
    const CpuTimer timer(cpu);
    rays += simulation.packet(index).rays;
  }
  return {static_cast<double>(rays) / cpu, 0.1 * static_cast<double>(packets) / cpu};
}

}  // namespace

TEST_CASE("a ray of any scene costs at most four times one of a bare room") {
  const aslio::test::TemporaryFolder folder;
  const Simulation bare(simulator::test::room(folder), {.sensor = SensorKind::avia});
  for (const auto& file : scene_files()) {
    const Simulation simulation(load_scene(file), {.sensor = SensorKind::avia});
    CAPTURE(file.stem().string());
    // One after the other in one process: machines differ by four times and more, and this share of them little.
    // A clock that was lowered between the two is no fault of the scene: of three attempts the best counts.
    double share = 0;
    CastCost best;
    for (int attempt = 0; attempt < 3 && share < 0.25; ++attempt) {
      const double yardstick = cost_of(bare).rays_per_s;
      const CastCost cost = cost_of(simulation);
      share = std::max(share, cost.rays_per_s / yardstick);
      if (cost.rays_per_s > best.rays_per_s) best = cost;
    }
    WARN(file.stem().string() << ": " << best.rays_per_s * 1e-6 << " M rays/s, " << best.times_real << " x real time, "
                              << share << " of the bare room's rate, " << simulation.caster().mesh().triangles.size()
                              << " triangles");
    CHECK(share > 0.25);  // measured 0.30 to 1.1
#ifdef ASLIO_SPEED_TESTS  // 1.2 M rays/s are 5 x real time
    const bool indoors = file.stem().string().find("indoor") == 0;
    CHECK(best.rays_per_s > (indoors ? 1.5e6 : 1.2e6));
#endif
  }
}
