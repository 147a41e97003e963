#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <numbers>
#include <set>

#include "aslio/simulator/analytic_world.hpp"
#include "aslio/stream/measurement_stream.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

/// The packets that begin in [begin, end) seconds.
std::vector<LidarPacket> packets(const AnalyticWorld& world, double begin, double end) {
  std::vector<LidarPacket> out;
  const auto source = world.source();
  while (auto m = source->next()) {
    auto* packet = std::get_if<LidarPacket>(&*m);
    if (packet == nullptr) continue;
    const double since = to_seconds(packet->stamp - world.begin_time());
    if (since >= end) break;
    if (since >= begin - 1e-9) out.push_back(std::move(*packet));
  }
  return out;
}

bool same(const LidarPacket& a, const LidarPacket& b) {
  const auto equal = [](const TimedPoint& p, const TimedPoint& q) {
    return p.x == q.x && p.y == q.y && p.z == q.z && p.t == q.t && p.line == q.line && p.intensity == q.intensity;
  };
  return a.stamp == b.stamp && std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), equal);
}

Vec3 in_world(const AnalyticWorld& world, const TimedPoint& p) {
  return world.pose(p.t) * (world.sensor().T_imu_lidar * Vec3(p.x, p.y, p.z));
}

}  // namespace

TEST_CASE("a wall seen in the fastest turn, placed with the true poses, is flat to the range noise") {
  const AnalyticWorld world;
  std::vector<double> off;
  for (const LidarPacket& packet : packets(world, 4.8, 5.2))
    for (const TimedPoint& p : packet.points) {
      const Vec3 w = in_world(world, p);
      // Face of the east wall, away from shelf and corners.
      if (std::abs(w.x() - 9) < 0.15 && w.y() > 0.2 && w.y() < 3.8 && w.z() > -1.2 && w.z() < 1.4)
        off.push_back(w.x() - 9);
    }
  REQUIRE(off.size() > 1000);
  double mean = 0, square = 0;
  for (const double d : off) mean += d / static_cast<double>(off.size());
  for (const double d : off) square += (d - mean) * (d - mean) / static_cast<double>(off.size());
  INFO("mean " << mean << " m, standard deviation " << std::sqrt(square) << " m of " << off.size() << " points");
  CHECK(std::abs(mean) < 0.002);
  CHECK(std::sqrt(square) < 0.022);
  CHECK(std::sqrt(square) > 0.015);
}

TEST_CASE("without noise every point lies on a surface") {
  Options options;
  options.lidar_noise = false;
  options.people = true;
  const AnalyticWorld world(options);
  double worst = 0;
  for (const LidarPacket& packet : packets(world, 8.8, 9.2))
    for (std::size_t i = 0; i < packet.points.size(); i += 7) {
      const Vec3 w = in_world(world, packet.points[i]);
      const double people = BoxScene(world.people(packet.points[i].t)).clearance(w);
      worst = std::max(worst, std::min(world.scene().clearance(w), people));
    }
  CHECK(worst < 2e-6);  // float coordinates at up to 20 m
}

TEST_CASE("points come at 240 kHz in firings of six, inside the field of view and the range gate") {
  const AnalyticWorld world;
  const std::vector<LidarPacket> all = packets(world, 0, 0.5);
  REQUIRE(all.size() == 5);
  for (const LidarPacket& packet : all) {
    CHECK(packet.points.size() > 22'000);
    CHECK(packet.points.size() < 24'000);
    std::set<TimeNs> times;
    TimeNs last = packet.stamp;
    for (const TimedPoint& p : packet.points) {
      REQUIRE(p.t >= last);
      last = p.t;
      times.insert(p.t);
      const double azimuth = std::atan2(p.y, p.x), elevation = std::atan2(p.z, std::hypot(p.x, p.y));
      REQUIRE(std::abs(azimuth) < 35.2 * std::numbers::pi / 180);
      REQUIRE(std::abs(elevation) < 38.6 * std::numbers::pi / 180);
      REQUIRE(Vec3(p.x, p.y, p.z).norm() >= world.sensor().min_range - 1e-6);
      REQUIRE((p.line < 6 && p.sweep_id == packet.sweep_id && (p.t - world.begin_time()) % 25'000 == 0));
    }
    CHECK(times.size() > 3990);
    CHECK(last < packet.stamp + kSecond / 10);
  }
}

TEST_CASE("same options, same bits, another seed, other noise, one noise does not disturb the other") {
  Options options;
  const AnalyticWorld a(options), b(options);
  options.seed = 2;
  const AnalyticWorld other(options);
  options.seed = 1;
  options.imu_noise = false;
  const AnalyticWorld ideal_imu(options);
  const auto pa = packets(a, 0, 0.3), pb = packets(b, 0, 0.3), po = packets(other, 0, 0.3);
  const auto pi = packets(ideal_imu, 0, 0.3);
  REQUIRE(pa.size() == 3);
  for (std::size_t i = 0; i < pa.size(); ++i) {
    CHECK(same(pa[i], pb[i]));
    CHECK(same(pa[i], pi[i]));
    CHECK_FALSE(same(pa[i], po[i]));
  }
  for (std::size_t i = 0; i < 100; ++i) {
    CHECK(a.imu().samples[i].acc == b.imu().samples[i].acc);
    CHECK(a.imu().samples[i].acc != other.imu().samples[i].acc);
  }
}

TEST_CASE("the source runs to the end in recording order, fast, and the stream takes it without a complaint") {
  const AnalyticWorld world;
  const auto source = world.source();
  stream::MeasurementStream stream;
  TimeNs recorded = world.begin_time();
  const std::clock_t started = std::clock();
  std::size_t packets = 0, imu = 0;
  while (auto m = source->next()) {
    if (auto* packet = std::get_if<LidarPacket>(&*m)) {
      ++packets;
      REQUIRE(packet->stamp + kSecond / 10 >= recorded);
      recorded = packet->stamp + kSecond / 10;
      stream.release(packet->stamp - 1);
      stream.push(std::move(*packet));
    } else {
      ++imu;
      REQUIRE(std::get<ImuSample>(*m).t >= recorded);
      recorded = std::get<ImuSample>(*m).t;
      stream.push(std::get<ImuSample>(*m));
    }
  }
  const double rays = 20 * 240e3 * CLOCKS_PER_SEC / static_cast<double>(std::clock() - started);
  INFO("rays per second: " << rays);
  CHECK(rays > 3e5);  // a fifth of what one usual core does
  CHECK(packets == 200);
  CHECK(imu == 4001);
  CHECK(source->status() == io::InputStatus::complete);
  CHECK(*source->end_time() == world.end_time());
  const stream::StreamCounters& c = stream.counters();
  CHECK(c.points > 4'400'000);
  CHECK(c.points_late + c.points_reordered + c.points_invalid + c.imu_late + c.imu_gaps + c.imu_reordered == 0);
  CHECK(stream.imu_period() == 5'000'000);
}
