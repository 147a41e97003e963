/// Every shipped family: a simulated stand-in of its first sequence, opened as a user opens the published one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "aslio/config/load.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/stand_in.hpp"
#include "aslio/io/reference.hpp"
#include "cli/child.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using experiment::Family;
using experiment::FamilySequence;

namespace {

namespace fs = std::filesystem;

constexpr double kDuration = 2.0;

/// A hall of 40 x 30 x 10 m with two blocks in it: large enough for a LiDAR that sees nothing nearer than 4 m.
constexpr const char* kHall =
    "v -15 -10 0\nv 25 -10 0\nv 25 20 0\nv -15 20 0\nv -15 -10 10\nv 25 -10 10\nv 25 20 10\nv -15 20 10\n"
    "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    "v 12 3 0\nv 14 3 0\nv 14 6 0\nv 12 6 0\nv 12 3 4\nv 14 3 4\nv 14 6 4\nv 12 6 4\n"
    "f 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16\n"
    "v 9 -8 0\nv 12 -8 0\nv 12 -6 0\nv 9 -6 0\nv 9 -8 3\nv 12 -8 3\nv 12 -6 3\nv 9 -6 3\n"
    "f 21 22 23 24\nf 17 18 22 21\nf 18 19 23 22\nf 19 20 24 23\nf 20 17 21 24\n";
constexpr const char* kScene =
    "schema: aslio/scene/1\nworld: {type: mesh, file: hall.obj}\n"
    "route: [{x: 0, y: 0}, {x: 6, y: 0}, {x: 6, y: 5}, {x: 0, y: 5}]\n"
    "walk: {standstill: 0.8}\nimu: {preset: ideal, gyro_bias: 0.05, acc_bias: 2}\n";

/// A stand-in as the command writes it, and the simulation that it comes from.
struct StandIn {
  TemporaryFolder folder;
  Family family;
  const FamilySequence& sequence;
  experiment::StandIn written;
  Ended ended;

  explicit StandIn(const fs::path& file)
      : family(experiment::load_family(file)),
        sequence(family.sequences.front()),
        written(experiment::stand_in_of(family, sequence)) {
    folder.write("hall.obj", kHall);
    folder.write("hall.yaml", kScene);
    std::vector<std::string> arguments = {
        "simulate", folder / "hall.yaml", "--as",       family.name + "/" + sequence.name,
        "--output", folder / "data",      "--duration", std::to_string(kDuration)};
    // Few lines need more columns to have enough points.
    const bool few = written.sensor.model.scan_lines <= 24;
    arguments.insert(arguments.end(), {"--set", few ? "lidar.columns=1000" : "lidar.columns=400"});
    ended = run_aslio(arguments);
  }

  simulator::Simulation simulation() const {
    simulator::SimulationOptions options;
    options.duration = kDuration;
    options.begin = to_ns(written.layout.begin);
    options.T_imu_lidar = written.sensor.model.T_imu_lidar;
    return {simulator::load_scene(folder / ("data/simulated/" + sequence.name + "/scene.yaml")), options};
  }
};

std::vector<fs::path> shipped_families() {
  return experiment::family_files(fs::path(ASLIO_SOURCE_DIR) / "configs/datasets");
}

bool of_kitti(const StandIn& stand_in) { return stand_in.written.layout.container == io::Container::kitti; }

/// Points of all sweeps by time and line; those that a drive of KITTI leaves out at both ends are not among them.
std::vector<TimedPoint> expected_points(const StandIn& stand_in, const simulator::Simulation& simulation) {
  std::vector<TimedPoint> all;
  for (std::size_t i = 0; i < simulation.packet_count(); ++i) {
    for (TimedPoint point : simulation.packet(i).packet.points) {
      point.line = static_cast<std::uint8_t>(point.line % stand_in.written.sensor.model.scan_lines);
      all.push_back(point);
    }
  }
  if (of_kitti(stand_in)) {
    const TimeNs half = 50'000'000;
    std::erase_if(all, [&](const TimedPoint& point) {
      return point.t <= simulation.begin_time() + half || point.t > simulation.end_time() - half;
    });
  }
  return all;
}

/// The measurements are those of the simulation: so many, at their times, in the LiDAR frame.
void check_measurements(const StandIn& stand_in, const simulator::Simulation& simulation, const Split& got) {
  const double period = stand_in.written.sensor.model.sweep_period;
  const auto in_packet = static_cast<std::size_t>(std::max(1.0, std::round(0.1 / period)));
  CHECK(got.packets.size() == simulation.packet_count() * in_packet - (of_kitti(stand_in) ? 1 : 0));
  REQUIRE(got.imu.size() == simulation.imu().samples.size());
  for (std::size_t i = 0; i < got.imu.size(); ++i) {
    const ImuSample& made = simulation.imu().samples[i];
    REQUIRE(std::abs(got.imu[i].t - made.t) <= 1);
    REQUIRE((got.imu[i].gyro - made.gyro).norm() < 1e-9);
    REQUIRE((got.imu[i].acc - made.acc).norm() < 1e-9);
  }
  std::vector<TimedPoint> points;
  for (const LidarPacket& packet : got.packets) points.insert(points.end(), packet.points.begin(), packet.points.end());
  std::vector<TimedPoint> made = expected_points(stand_in, simulation);
  REQUIRE(points.size() == made.size());
  // By place: times are what is to be checked.
  const auto by_place = [](const TimedPoint& a, const TimedPoint& b) {
    return std::tie(a.x, a.y, a.z, a.t) < std::tie(b.x, b.y, b.z, b.t);
  };
  if (stand_in.written.layout.lidar.form == io::LidarForm::velodyne_packets) return;  // rounded: see test_packets.cpp
  std::sort(points.begin(), points.end(), by_place);
  std::sort(made.begin(), made.end(), by_place);
  for (std::size_t i = 0; i < points.size(); ++i) {
    REQUIRE((points[i].x == made[i].x && points[i].y == made[i].y && points[i].z == made[i].z));
    REQUIRE(std::abs(points[i].t - made[i].t) <= 1000);
  }
}

/// The reference, moved to the IMU as an evaluation does it, is the truth.
void check_reference(const StandIn& stand_in, const simulator::Simulation& simulation,
                     const io::ReferenceSpec& published) {
  const io::ReferenceSpec spec = io::with_protocol(published);
  const io::Reference reference = io::read_reference(spec);
  const Pose T_imu_reference = io::pose_in_imu(spec, stand_in.written.sensor.all_transforms());
  REQUIRE(reference.poses.size() > 5);
  const auto& origin = stand_in.written.layout.reference.origin;
  for (const StampedPose& pose : reference.poses) {
    const auto motion = simulation.motion().at(to_seconds(pose.t - simulation.begin_time()));
    const Pose truth = Pose{motion.R, motion.p} * T_imu_reference;
    CHECK((pose.T.p - truth.p - Vec3(origin[0], origin[1], origin[2])).norm() < 1e-6);
    if (!reference.positions_only) CHECK((pose.T.R - truth.R).norm() < 1e-6);
  }
}

void check_run(const StandIn& stand_in, const simulator::Simulation& simulation, const Recording& recording) {
  SensorModel sensor = stand_in.written.sensor.model;
  if (!stand_in.written.sensor_noise) {
    // KITTI's file has noise for an IMU of 10 Hz: with it, a walk of 2 s has 0.05 m, with that of the IMU 0.001 m.
    const SensorModel& made = simulation.sensor();
    sensor.gyro_noise = made.gyro_noise;
    sensor.acc_noise = made.acc_noise;
  }
  Run run(shipped("as_lio_plus"), sensor);
  run.play(recording);
  REQUIRE(run.updates.size() > 5);
  const evaluation::Evaluation error = evaluation::evaluate(run.trajectory(), simulation.truth());
  CAPTURE(error.ate.translation.rmse);
  CHECK(error.ate.translation.rmse < 0.02);
}

void check_family(const fs::path& file) {
  const StandIn stand_in(file);
  INFO(stand_in.ended.err);
  REQUIRE(stand_in.ended.code == 0);
  CHECK_THAT(stand_in.ended.out, Contains("SIMULATED") && Contains("not the published data"));
  const fs::path data = stand_in.folder / "data";
  CHECK_THAT(content(data / "SIMULATED.md"), Contains("The data in this folder are simulated."));
  const experiment::Dataset dataset = experiment::dataset_of(stand_in.family, stand_in.sequence, data);
  const auto source = io::open_source(dataset.inputs, stand_in.written.sensor);
  const Recording recording = record(*source);
  CHECK(source->status() == io::InputStatus::complete);
  const simulator::Simulation simulation = stand_in.simulation();
  check_measurements(stand_in, simulation, split(recording));
  if (dataset.reference) check_reference(stand_in, simulation, *dataset.reference);
  check_run(stand_in, simulation, recording);
}

}  // namespace

TEST_CASE("stand-ins: each shipped family reads that of its first sequence, and a run on it is right") {
  const auto families = shipped_families();
  REQUIRE(families.size() >= 12);
  for (const fs::path& file : families) {
    CAPTURE(file.filename().string());
    check_family(file);
  }
}
