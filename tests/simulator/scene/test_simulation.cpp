#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/simulation.hpp"
#include "simulator/box_room.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

bool same_points(const LidarPacket& a, const LidarPacket& b) {
  if (a.points.size() != b.points.size()) return false;
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    const TimedPoint &p = a.points[k], &q = b.points[k];
    if (p.x != q.x || p.y != q.y || p.z != q.z || p.t != q.t || p.line != q.line || p.intensity != q.intensity)
      return false;
  }
  return true;
}

}  // namespace

TEST_CASE("packets do not depend on the order in which they are simulated", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = simulator::test::room(folder, "people: {walking: 2}\n");
  const Simulation a(file, {}), b(file, {});
  const LidarPacket late = a.packet(20).packet, early = a.packet(3).packet;
  CHECK(same_points(b.packet(3).packet, early));
  CHECK(same_points(b.packet(20).packet, late));
  const Simulation other(file, {.seed = 2});
  CHECK_FALSE(same_points(other.packet(3).packet, early));
}

TEST_CASE("packets tile the time of the recording", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const Simulation simulation(simulator::test::room(folder, "lidar: {noise: false}\n"), {});
  const std::size_t last = simulation.packet_count() - 1;
  CHECK(simulation.packet(0).packet.points.front().t == simulation.begin_time());
  TimeNs previous = simulation.packet(0).packet.points.back().t;
  for (std::size_t index = 1; index <= last; index += 10) {
    const SimulatedPacket packet = simulation.packet(index);
    const auto& points = packet.packet.points;
    CHECK(points.front().t > previous);
    CHECK(points.front().t >= packet.packet.stamp);
    CHECK(points.back().t < packet.packet.stamp + Simulation::kPacketPeriod);
    CHECK(std::is_sorted(points.begin(), points.end(), [](auto& p, auto& q) { return p.t < q.t; }));
    previous = points.back().t;
  }
  CHECK(simulation.packet(last).packet.points.back().t < simulation.end_time());
  CHECK(simulation.imu().samples.front().t == simulation.begin_time());
  CHECK(std::abs(simulation.imu().samples.back().t - simulation.end_time()) <= kSecond / 200);
  CHECK(simulation.truth().begin_time() == simulation.begin_time());
  CHECK(simulation.truth().end_time() == simulation.end_time());
}

TEST_CASE("a closed room returns every ray of an ideal sensor onto its walls", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const Simulation simulation(
      simulator::test::room(folder, "lidar: {noise: false, grazing_begin: 89.9, grazing_end: 90}\n"), {});
  using namespace simulator::test;
  const SimulatedPacket packet = simulation.packet(25);
  CHECK(packet.rays == 24000);
  CHECK(packet.packet.points.size() > 23900);
  CHECK(packet.blocks.size() == 10);
  double worst = 0;
  for (const TimedPoint& point : packet.packet.points) {
    const MotionState m = simulation.motion().at(to_seconds(point.t - simulation.begin_time()));
    const Vec3 p = Pose{m.R, m.p} * (simulation.sensor().T_imu_lidar * Vec3(point.x, point.y, point.z));
    const double off = std::min({std::abs(p.x() - kWestWall), std::abs(p.x() - kEastWall), std::abs(p.y() - kSouthWall),
                                 std::abs(p.y() - kNorthWall), std::abs(p.z()), std::abs(p.z() - 3)});
    worst = std::max(worst, off);
  }
  CHECK(worst < 1e-5);
}

TEST_CASE("the sensor file of a stress study differs from the sensor as told", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const SceneFile file = simulator::test::room(folder, "stress: {extrinsic_angle: 2, extrinsic_offset: 0.05}\n");
  const Simulation simulation(file, {});
  const Pose &truth = simulation.sensor().T_imu_lidar, &claimed = simulation.claimed_sensor().T_imu_lidar;
  CHECK(Eigen::AngleAxisd(claimed.R * truth.R.transpose()).angle() == Approx(2 * M_PI / 180));
  CHECK((claimed.p - truth.p).norm() == Approx(0.05));
}

TEST_CASE("cells are told apart on all sides of the origin", "[simulation]") {
  // Faces at 0.0937, 0.0719, 0.0613 and every 0.2 m from there.
  CHECK(cell_key({0.1, 0.08, 0.07}) == cell_key({0.29, 0.27, 0.26}));
  CHECK(cell_key({0.1, 0.08, 0.07}) != cell_key({0.09, 0.08, 0.07}));
  CHECK(cell_key({0.1, 0.08, 0.07}) != cell_key({0.1, 0.28, 0.07}));
  CHECK(cell_key({0.1, 0.08, 0.07}) != cell_key({0.1, 0.08, 0.06}));
  CHECK(cell_key({-0.1, -0.1, -0.1}) == cell_key({0.09, 0.07, 0.06}));
  CHECK(cell_key({-0.1, -0.1, -0.1}) != cell_key({-0.11, -0.1, -0.1}));
  CHECK(cell_key({900, -900, 5}) == cell_key({900.05, -899.95, 5.05}));
}

TEST_CASE("a surface at a round coordinate falls into one layer of cells", "[simulation]") {
  // The last bit of a hit may say either side.
  for (const double z : {0.0, 0.2, 2.0, -1.4, 2.7, 7.0, -6.0, 0.1}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 p = Vec3::Constant(0.5);
      p[axis] = z;
      Vec3 nudge = Vec3::Zero();
      nudge[axis] = 1e-6;
      CHECK(cell_key(p + nudge) == cell_key(p - nudge));
    }
  }
}

TEST_CASE("what a scene asks for and cannot have is told with its file", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const auto message = [&](const std::string& more, double scale = 1) {
    SimulationOptions options;
    options.scale = scale;
    try {
      const Simulation simulation(simulator::test::room(folder, more), options);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(message("", 50), Contains("scale is 50"));
  CHECK_THAT(message("", 0.1), Contains("room.yaml: ") && Contains("at scale 0.1"));
}

TEST_CASE("a motion too long for the memory is refused before it is simulated", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  folder.write("room.obj", simulator::test::kRoomObj);
  const SceneFile scene =
      load_scene(folder.write("long.yaml", simulator::test::room_scene("imu: {rate: 10000}\n")), {"walk.laps=1000"});
  CHECK_THROWS_WITH(Simulation(scene, {}),
                    Catch::Matchers::Contains("long.yaml: ") && Catch::Matchers::Contains("walk.laps"));
}

TEST_CASE("a VLP-16 whose lasers leave from different heights sees the same walls", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  SimulationOptions options;
  options.sensor = SensorKind::vlp16;
  options.duration = 1.0;
  options.T_imu_lidar =
      Pose{Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()).toRotationMatrix(), Vec3(0.2, -0.1, 0.3)};
  const Simulation simulation(
      simulator::test::room(folder, "lidar: {noise: false, grazing_begin: 89.9, grazing_end: 90}\n"), options);
  using namespace simulator::test;
  CHECK(simulation.packet_count() == 10);
  CHECK(simulation.end_time() == simulation.begin_time() + kSecond);
  CHECK(simulation.imu().samples.back().t <= simulation.end_time());
  CHECK(simulation.claimed_sensor().T_imu_lidar.p == options.T_imu_lidar->p);
  TimeNs last = -1;
  for (std::size_t index = 0; index < simulation.packet_count(); ++index) {
    const SimulatedPacket packet = simulation.packet(index);
    CHECK(packet.blocks.size() == 10);
    double worst = 0;
    for (const TimedPoint& point : packet.packet.points) {
      const TimeNs since = point.t - simulation.begin_time();
      CHECK((since % 55'296 == 0 && since >= last));
      last = since;
      const MotionState m = simulation.motion().at(to_seconds(since));
      const Vec3 p = Pose{m.R, m.p} * *options.T_imu_lidar * Vec3(point.x, point.y, point.z);
      const double off =
          std::min({std::abs(p.x() - kWestWall), std::abs(p.x() - kEastWall), std::abs(p.y() - kSouthWall),
                    std::abs(p.y() - kNorthWall), std::abs(p.z()), std::abs(p.z() - 3)});
      worst = std::max(worst, off);
    }
    CHECK(worst < 1e-5);
  }
}
