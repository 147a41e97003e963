/// What a stress study does to a recording.

#include <catch2/catch.hpp>
#include <cmath>

#include "recorded.hpp"

using namespace aslio;
using namespace aslio::simulator;
using simulator::test::Recorded;
using simulator::test::Stamps;
using simulator::test::stamps;

namespace {

const std::string kImuTopic = "/livox/imu", kLidarTopic = "/livox/lidar";

}  // namespace

TEST_CASE("without stress every message has its own time and arrives in order", "[record]") {
  const Recorded recorded;
  const Stamps imu = stamps(recorded, kImuTopic), lidar = stamps(recorded, kLidarTopic);
  CHECK(imu.stamp == imu.arrival);
  REQUIRE(lidar.stamp.size() == recorded.simulation.packet_count());
  for (std::size_t k = 0; k + 1 < lidar.stamp.size(); ++k)
    CHECK(lidar.arrival[k] == lidar.stamp[k] + Simulation::kPacketPeriod);
}

TEST_CASE("a clock offset moves the stamps of the IMU", "[record]") {
  const Stamps imu = stamps(Recorded("stress: {clock_offset: 7.5}\n"), kImuTopic);
  for (std::size_t k = 0; k < imu.stamp.size(); ++k) REQUIRE(imu.stamp[k] - imu.arrival[k] == 7'500'000);
}

TEST_CASE("jitter of stamps has its standard deviation and keeps their order", "[record]") {
  const Stamps imu = stamps(Recorded("stress: {stamp_jitter: 400}\nimu: {rate: 1000}\n"), kImuTopic);
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < imu.stamp.size(); ++k) {
    const double us = 1e-3 * static_cast<double>(imu.stamp[k] - imu.arrival[k]);
    sum += us;
    squares += us * us;
    if (k > 0) REQUIRE(imu.stamp[k] > imu.stamp[k - 1]);
  }
  const auto n = static_cast<double>(imu.stamp.size());
  REQUIRE(n > 5000);
  CHECK(std::sqrt(squares / n) == Approx(400).epsilon(0.1));
  CHECK(std::abs(sum / n) < 40);
}

TEST_CASE("lost messages are a share of all, the others stay as they are", "[record]") {
  const Recorded whole, holes("stress: {packet_loss: 0.3, imu_loss: 0.2}\n");
  const Stamps imu = stamps(holes, kImuTopic), lidar = stamps(holes, kLidarTopic);
  const auto share = [](std::size_t part, std::size_t all) {
    return static_cast<double>(part) / static_cast<double>(all);
  };
  CHECK(share(imu.stamp.size(), stamps(whole, kImuTopic).stamp.size()) == Approx(0.8).margin(0.05));
  CHECK(share(lidar.stamp.size(), stamps(whole, kLidarTopic).stamp.size()) == Approx(0.7).margin(0.18));
  CHECK(holes.result.packets == lidar.stamp.size());
  CHECK(holes.result.imu_samples == imu.stamp.size());
  CHECK(imu.stamp == imu.arrival);
}

TEST_CASE("a wrong extrinsic stands in the sensor file alone", "[record]") {
  const Recorded right, wrong("stress: {extrinsic_angle: 2, extrinsic_offset: 0.05}\n");
  CHECK(right.result.bag_sha256 == wrong.result.bag_sha256);
  const Pose& claimed = wrong.simulation.claimed_sensor().T_imu_lidar;
  const Pose& truth = wrong.simulation.sensor().T_imu_lidar;
  CHECK((claimed.p - truth.p).norm() == Approx(0.05));
  CHECK(std::acos(0.5 * ((claimed.R.transpose() * truth.R).trace() - 1)) * 180 / 3.14159265358979 == Approx(2));
}
