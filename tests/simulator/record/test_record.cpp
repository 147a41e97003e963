/// What stands in a recording is what was simulated.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using Catch::Matchers::Contains;
using simulator::test::Recorded;
namespace fs = std::filesystem;

namespace {

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

/// Rows of numbers below a header.
std::vector<std::vector<double>> rows(const fs::path& path) {
  std::ifstream file(path);
  std::string line, cell;
  std::getline(file, line);
  std::vector<std::vector<double>> table;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    table.emplace_back();
    while (std::getline(cells, cell, ',')) table.back().push_back(std::stod(cell));
  }
  return table;
}

/// Sensor files name no stages.
class NoStages final : public config::StageLookup {
 public:
  const config::StageEntry* find(std::string_view, std::string_view) const override { return nullptr; }
  std::vector<std::string> families() const override { return {}; }
  std::vector<std::string> types(std::string_view) const override { return {}; }
};

io::SensorConfig sensor_of(const Recorded& recorded) {
  return config::load<io::SensorConfig>(recorded / "sensor.yaml", config::FileKind::sensor, NoStages{}).value;
}

struct Read {
  std::vector<LidarPacket> packets;
  std::vector<ImuSample> imu;
};

Read read(const Recorded& recorded) {
  Read all;
  const auto source = io::open_source(recorded / "quick.bag", sensor_of(recorded));
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      all.packets.push_back(*packet);
    } else {
      all.imu.push_back(std::get<ImuSample>(*measurement));
    }
  }
  CHECK(source->status() == io::InputStatus::complete);
  CHECK(source->notes().warnings.empty());
  return all;
}

}  // namespace

TEST_CASE("a recording is a dataset whose bag holds what was simulated", "[record]") {
  const Recorded recorded("people: {crossing: 1}\n");
  const experiment::Dataset dataset = experiment::load_dataset(recorded / "dataset.yaml");
  CHECK(dataset.name == "quick");
  CHECK(dataset.description == "A test of <recordings> & \"more\".");
  CHECK(dataset.closed_loop);
  CHECK(sha256_of_file(dataset.inputs.front()) == recorded.result.bag_sha256);
  const Read bag = read(recorded);
  const Simulation& simulation = recorded.simulation;
  REQUIRE(bag.packets.size() == simulation.packet_count());
  CHECK(recorded.result.packets == bag.packets.size());
  std::size_t points = 0;
  for (std::size_t index = 0; index < bag.packets.size(); ++index) {
    const auto made = simulation.packet(index).packet.points;
    const auto& got = bag.packets[index].points;
    points += made.size();
    REQUIRE(got.size() == made.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
      const bool same = got[k].x == made[k].x && got[k].y == made[k].y && got[k].z == made[k].z &&
                        got[k].t == made[k].t && got[k].line == made[k].line && got[k].intensity == made[k].intensity;
      REQUIRE(same);
    }
  }
  CHECK(recorded.result.points == points);
  REQUIRE(bag.imu.size() == simulation.imu().samples.size());
  CHECK(recorded.result.imu_samples == bag.imu.size());
  for (std::size_t k = 0; k < bag.imu.size(); ++k) {
    const ImuSample& made = simulation.imu().samples[k];
    REQUIRE(bag.imu[k].t == made.t);
    REQUIRE(bag.imu[k].gyro == made.gyro);
    REQUIRE((bag.imu[k].acc - made.acc).norm() < 1e-12);
  }
}

TEST_CASE("a spinning sensor is recorded as a cloud with ring and time", "[record]") {
  SimulationOptions options;
  options.sensor = SensorKind::spin16;
  const Recorded recorded("", 1, options);
  const Read bag = read(recorded);
  REQUIRE(bag.packets.size() == recorded.simulation.packet_count());
  for (std::size_t index = 0; index < bag.packets.size(); index += 7) {
    const auto made = recorded.simulation.packet(index).packet.points;
    const auto& got = bag.packets[index].points;
    REQUIRE(got.size() == made.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
      REQUIRE((got[k].x == made[k].x && got[k].y == made[k].y && got[k].z == made[k].z && got[k].line == made[k].line));
      REQUIRE(std::abs(got[k].t - made[k].t) <= 10);  // single precision seconds
    }
  }
  REQUIRE(bag.imu.size() == recorded.simulation.imu().samples.size());
  CHECK(bag.imu[100].acc == recorded.simulation.imu().samples[100].acc);
}

TEST_CASE("truth is the motion, with the biases of the IMU", "[record]") {
  const Recorded recorded;
  const Simulation& simulation = recorded.simulation;
  const Trajectory truth(io::read_tum(recorded / "truth.tum"));
  const auto table = rows(recorded / "truth.csv");
  REQUIRE(table.size() == truth.size());
  CHECK(truth.size() == simulation.truth().size());
  for (std::size_t k = 0; k < table.size(); k += 13) {
    REQUIRE(table[k].size() == 20);
    const StampedPose& pose = truth.samples()[k];
    const MotionState m = simulation.motion().at(to_seconds(pose.t - simulation.begin_time()));
    CHECK((pose.T.p - m.p).norm() < 1e-8);
    CHECK((pose.T.R - m.R).norm() < 1e-8);
    const auto v3 = [&](std::size_t column) {
      return Vec3(table[k][column], table[k][column + 1], table[k][column + 2]);
    };
    CHECK((v3(1) - m.p).norm() < 1e-7);
    CHECK((v3(4) - m.v).norm() < 1e-7);
    CHECK((v3(11) - m.w).norm() < 1e-7);
    if (k + 1 < table.size()) {  // one IMU sample for each pose, but for the last
      CHECK((v3(14) - simulation.imu().gyro_bias[k]).norm() < 1e-8);
      CHECK((v3(17) - simulation.imu().acc_bias[k]).norm() < 1e-8);
    }
  }
  CHECK(recorded.result.path_length_m == Approx(truth.path_length()).margin(1e-6));
}

TEST_CASE("true overlap is the share of rays on cells that earlier blocks have hit", "[record]") {
  const Recorded recorded("people: {crossing: 2}\n");
  const auto table = rows(recorded / "overlap.csv");
  std::set<std::uint64_t> seen;
  std::size_t row = 0, people = 0;
  for (std::size_t index = 0; index < recorded.simulation.packet_count(); ++index) {
    for (const CellBlock& block : recorded.simulation.packet(index).blocks) {
      std::size_t known = 0;
      for (const std::uint64_t cell : block.cells) known += seen.count(cell);
      seen.insert(block.cells.begin(), block.cells.end());
      REQUIRE(row < table.size());
      const auto& line = table[row++];
      CHECK(line[1] == static_cast<double>(block.cells.size()));
      if (!block.cells.empty())
        CHECK(line[2] == Approx(static_cast<double>(known) / static_cast<double>(block.cells.size())).margin(1e-6));
      CHECK(line[3] == static_cast<double>(block.people_rays));
      people += block.people_rays;
    }
  }
  CHECK(row == table.size());
  CHECK(people > 100);
  CHECK(table.front()[2] == 0);
  CHECK(table[40][2] > 0.9);      // standing still
  CHECK(table.back()[2] > 0.95);  // the room is known
}

TEST_CASE("the scene as simulated makes the same bag again", "[record]") {
  SimulationOptions options;
  options.seed = 5;
  options.scale = 0.5;
  options.sensor = SensorKind::spin16;
  const Recorded recorded("", 1, options);
  const std::string text = content(recorded / "scene.yaml");
  CHECK_THAT(text, Contains("--seed 5 --scale 0.5") && Contains("sensor: spin16"));
  const SceneFile scene = load_scene(recorded / "scene.yaml");
  options.sensor.reset();
  const Simulation simulation(scene, options);
  RecordResult result;
  REQUIRE(record(simulation, scene, {recorded / "again", 2, true, "quick"}, nullptr, result));
  CHECK(result.bag_sha256 == recorded.result.bag_sha256);
  CHECK(content(recorded / "again/scene.yaml") == text);
}

TEST_CASE("any number of threads makes the same files", "[record]") {
  const Recorded one("people: {walking: 2}\n", 1), two("people: {walking: 2}\n", 2), five("people: {walking: 2}\n", 5);
  CHECK(one.result.bag_sha256 == two.result.bag_sha256);
  CHECK(one.result.bag_sha256 == five.result.bag_sha256);
  for (const std::string& name : names_in(one / "")) {
    if (name == "scene.yaml") continue;  // names the folder of the mesh
    CAPTURE(name);
    CHECK(content(one / name) == content(two / name));
  }
  SimulationOptions options;
  options.seed = 2;
  CHECK(Recorded("people: {walking: 2}\n", 1, options).result.bag_sha256 != one.result.bag_sha256);
}

TEST_CASE("a recording that is stopped leaves no half-written file", "[record]") {
  const Recorded recorded;
  RecordResult result;
  const auto stop = [](double share) { return share < 0.3; };
  CHECK_FALSE(record(recorded.simulation, recorded.scene, {recorded / "stopped", 1, true, "quick"}, stop, result));
  CHECK(names_in(recorded / "stopped").empty());
  // Over an earlier recording: what remains is whole, and no dataset file vouches for the mixture.
  const std::string bag = content(recorded / "quick.bag");
  CHECK_FALSE(record(recorded.simulation, recorded.scene, {recorded / "", 1, true, "quick"}, stop, result));
  CHECK_FALSE(fs::exists(recorded / "dataset.yaml"));
  CHECK(content(recorded / "quick.bag") == bag);
}

TEST_CASE("progress runs from nothing to all", "[record]") {
  const Recorded recorded;
  RecordResult result;
  std::vector<double> shares;
  const auto note = [&](double share) {
    shares.push_back(share);
    return true;
  };
  REQUIRE(record(recorded.simulation, recorded.scene, {recorded / "again", 1, true, "quick"}, note, result));
  CHECK(std::is_sorted(shares.begin(), shares.end()));
  CHECK(shares.size() > 5);
  CHECK(shares.back() == 1);
}

TEST_CASE("a folder that cannot be written is named", "[record]") {
  const Recorded recorded;
  RecordResult result;
  recorded.folder.write("file", "");
  CHECK_THROWS_WITH(
      record(recorded.simulation, recorded.scene, {recorded.folder / "file", 1, true, "quick"}, nullptr, result),
      Contains("file"));
}

TEST_CASE("a world that no ray meets is told with where it is, and is no dataset", "[record]") {
  const aslio::test::TemporaryFolder folder;
  folder.write("room.obj", simulator::test::kRoomObj);
  const SceneFile scene =
      load_scene(folder.write("far.yaml", simulator::test::quick_scene()), {"world.unit=0.001", "walk.height=5"});
  const Simulation simulation(scene, {});
  RecordResult result;
  CHECK_THROWS_WITH(record(simulation, scene, {folder / "out", 1, true, "far"}, nullptr, result),
                    Contains("room.obj: no ray has returned") && Contains("unit"));
  CHECK_FALSE(fs::exists(folder / "out/dataset.yaml"));
  CHECK_FALSE(fs::exists(folder / "out/far.bag"));
}
