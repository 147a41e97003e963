/// A bare wall seen during the fastest turn, placed with the true poses, is as flat as the noise lets it be.

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/simulation.hpp"
#include "simulator/box_room.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// Index of the packet in whose middle the sensor turns fastest, and the rate [rad/s].
std::pair<std::size_t, double> fastest_turn(const Simulation& simulation) {
  std::pair<std::size_t, double> best{0, 0};
  for (std::size_t index = 0; index < simulation.packet_count(); ++index) {
    const double rate = simulation.motion().at(0.1 * static_cast<double>(index) + 0.05).w.norm();
    if (rate > best.second) best = {index, rate};
  }
  return best;
}

struct Flatness {
  double rms = 0, expected = 0;  ///< of the distance to the fitted plane [m]
  std::size_t points = 0;
};

/// Upright wall at the coordinate `at` of an axis.
struct Wall {
  int axis = 0;
  double at = 0;
};
constexpr Wall kWalls[] = {{0, simulator::test::kWestWall},
                           {0, simulator::test::kEastWall},
                           {1, simulator::test::kSouthWall},
                           {1, simulator::test::kNorthWall}};

/// Whether true positions say that a point lies on the wall, away from its edges.
bool on_wall(const Wall& wall, const Vec3& p_W) {
  const Vec3 low(simulator::test::kWestWall, simulator::test::kSouthWall, 0);
  const Vec3 high(simulator::test::kEastWall, simulator::test::kNorthWall, 3);
  for (int axis = 0; axis < 3; ++axis)
    if (axis != wall.axis && (p_W[axis] < low[axis] + 0.3 || p_W[axis] > high[axis] - 0.3)) return false;
  return std::abs(p_W[wall.axis] - wall.at) < 0.3;
}

/// Points of one wall of the room; the plane is fitted, not known.
Flatness flatness(const Simulation& simulation, const LidarPacket& packet, const Wall& wall, bool with_poses) {
  const double range_noise = facts(simulation.sensor_kind()).range_noise;
  const double angle_noise = facts(simulation.sensor_kind()).angle_noise;
  std::vector<Vec3> placed;
  double variance = 0;
  const MotionState middle = simulation.motion().at(to_seconds(packet.stamp - simulation.begin_time()) + 0.05);
  for (const TimedPoint& point : packet.points) {
    const MotionState m = simulation.motion().at(to_seconds(point.t - simulation.begin_time()));
    const Vec3 p_I = simulation.sensor().T_imu_lidar * Vec3(point.x, point.y, point.z);
    const Vec3 p_W = m.R * p_I + m.p;
    if (!on_wall(wall, p_W)) continue;
    placed.push_back(with_poses ? p_W : Vec3(middle.R * p_I + middle.p));
    const double range = Vec3(point.x, point.y, point.z).norm();
    const double cosine = std::abs(wall.at - m.p[wall.axis]) / range, sine2 = 1 - cosine * cosine;
    variance += std::pow(range_noise * cosine, 2) + sine2 * std::pow(angle_noise * range, 2);
  }
  Flatness result;
  result.points = placed.size();
  if (placed.size() < 100) return result;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : placed) mean += p / static_cast<double>(placed.size());
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : placed) scatter += (p - mean) * (p - mean).transpose();
  const double least = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvalues()[0];
  result.rms = std::sqrt(least / static_cast<double>(placed.size()));
  result.expected = std::sqrt(variance / static_cast<double>(placed.size()));
  return result;
}

}  // namespace

TEST_CASE("a wall seen in the fastest turn is flat to the range noise", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const std::string fast = "lidar: {dropout: 0, outliers: 0, mixed: 0}\n";
  const Simulation simulation(simulator::test::room(folder, fast), {});
  const auto [index, rate] = fastest_turn(simulation);
  REQUIRE(rate > 3.14);  // 180 deg/s
  std::size_t walls = 0, smeared = 0;
  for (std::size_t k = index - 2; k <= index + 2; ++k) {
    const LidarPacket packet = simulation.packet(k).packet;
    const bool turning = simulation.motion().at(0.1 * static_cast<double>(k) + 0.05).w.norm() > 3;
    for (const Wall& wall : kWalls) {
      const Flatness placed = flatness(simulation, packet, wall, true);
      if (placed.points < 1000) continue;
      ++walls;
      CAPTURE(k, wall.axis, wall.at, placed.points, placed.rms, placed.expected);
      CHECK(placed.rms == Approx(placed.expected).epsilon(0.05));
      // The test can tell: with one pose for the whole packet the wall smears.
      if (turning) smeared += flatness(simulation, packet, wall, false).rms > 3 * placed.expected;
    }
  }
  CHECK(walls >= 4);
  CHECK(smeared >= 2);
}

TEST_CASE("without noise a wall seen in the fastest turn is exactly flat", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const Simulation simulation(simulator::test::room(folder, "lidar: {noise: false}\n"), {});
  const auto [index, rate] = fastest_turn(simulation);
  std::size_t walls = 0;
  for (std::size_t k = index - 2; k <= index + 2; ++k) {
    const LidarPacket packet = simulation.packet(k).packet;
    for (const Wall& wall : kWalls) {
      const Flatness placed = flatness(simulation, packet, wall, true);
      if (placed.points < 1000) continue;
      ++walls;
      CHECK(placed.rms < 1e-5);
    }
  }
  CHECK(walls >= 4);
}
