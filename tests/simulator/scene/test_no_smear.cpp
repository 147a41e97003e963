/// A bare wall seen during the fastest turn, placed with the true poses, is as flat as the noise lets it be.

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/simulation.hpp"
#include "box_room.hpp"

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

/// Points of one wall of the room, which true positions tell apart; the plane is fitted, not known.
Flatness flatness(const Simulation& simulation, const LidarPacket& packet, bool with_poses) {
  const double range_noise = facts(simulation.sensor_kind()).range_noise;
  const double angle_noise = facts(simulation.sensor_kind()).angle_noise;
  std::vector<Vec3> placed;
  double variance = 0;
  const MotionState middle = simulation.motion().at(to_seconds(packet.stamp - simulation.begin_time()) + 0.05);
  for (const TimedPoint& point : packet.points) {
    const MotionState m = simulation.motion().at(to_seconds(point.t - simulation.begin_time()));
    const Vec3 p_I = simulation.sensor().T_imu_lidar * Vec3(point.x, point.y, point.z);
    const Vec3 p_W = m.R * p_I + m.p;
    const double off = std::abs(p_W.y() - test::kNorthWall);
    const bool inside =
        p_W.x() > test::kWestWall + 0.3 && p_W.x() < test::kEastWall - 0.3 && p_W.z() > 0.3 && p_W.z() < 2.7;
    if (off > 0.3 || !inside) continue;
    placed.push_back(with_poses ? p_W : Vec3(middle.R * p_I + middle.p));
    const double range = Vec3(point.x, point.y, point.z).norm();
    const double cosine = (test::kNorthWall - m.p.y()) / range, sine2 = 1 - cosine * cosine;
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
  const Simulation simulation(test::room(folder, fast), {});
  const auto [index, rate] = fastest_turn(simulation);
  REQUIRE(rate > 3.14);  // 180 deg/s
  std::size_t walls = 0;
  for (std::size_t k = index - 2; k <= index + 2; ++k) {
    const LidarPacket packet = simulation.packet(k).packet;
    const Flatness placed = flatness(simulation, packet, true);
    if (placed.points < 1000) continue;
    ++walls;
    CAPTURE(k, placed.points, placed.rms, placed.expected);
    CHECK(placed.rms == Approx(placed.expected).epsilon(0.05));
    // The test can tell: with one pose for the whole packet the wall smears.
    if (simulation.motion().at(0.1 * static_cast<double>(k) + 0.05).w.norm() > 3)
      CHECK(flatness(simulation, packet, false).rms > 3 * placed.expected);
  }
  CHECK(walls >= 2);
}

TEST_CASE("without noise a wall seen in the fastest turn is exactly flat", "[simulation]") {
  const aslio::test::TemporaryFolder folder;
  const Simulation simulation(test::room(folder, "lidar: {noise: false}\n"), {});
  const auto [index, rate] = fastest_turn(simulation);
  std::size_t walls = 0;
  for (std::size_t k = index - 2; k <= index + 2; ++k) {
    const Flatness placed = flatness(simulation, simulation.packet(k).packet, true);
    if (placed.points < 1000) continue;
    ++walls;
    CHECK(placed.rms < 1e-5);
  }
  CHECK(walls >= 2);
}
