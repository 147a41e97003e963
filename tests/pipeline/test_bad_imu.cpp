// What an IMU reads that is not so, in runs of the analytic world: spikes, ends of a range, stuck and dead sensors, and
// clocks that jump.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using pipeline::TrackingStatus;

namespace {

/// The recording with every IMU sample of [begin, end) changed.
Recording spoiled(Recording recording, TimeNs begin, TimeNs end, const std::function<void(ImuSample&)>& change) {
  for (Measurement& m : recording) {
    auto* imu = std::get_if<ImuSample>(&m);
    if (imu != nullptr && imu->t >= begin && imu->t < end) change(*imu);
  }
  return recording;
}

/// The recording with all stamps from `t` on moved by `by`.
Recording moved(Recording recording, TimeNs t, TimeNs by) {
  for (Measurement& m : recording) {
    if (auto* imu = std::get_if<ImuSample>(&m)) imu->t += imu->t >= t ? by : 0;
    auto* packet = std::get_if<LidarPacket>(&m);
    if (packet == nullptr || packet->stamp < t) continue;
    packet->stamp += by;
    for (TimedPoint& p : packet->points) p.t += by;
  }
  return recording;
}

/// RMS of the positions against the truth, in the frame of the first pose [m].
double error(const Run& run, const simulator::AnalyticWorld& world) {
  const auto& first = run.updates.front().state;
  const Pose W = world.pose(first.t) * first.pose().inverse();
  double squares = 0;
  for (const auto& u : run.updates) squares += (W * u.state.p - world.pose(u.state.t).p).squaredNorm();
  return std::sqrt(squares / static_cast<double>(run.updates.size()));
}

/// The moment of the fastest turn.
TimeNs sharpest_turn(const Recording& recording) {
  TimeNs at = 0;
  double fastest = 0;
  for (const Measurement& m : recording) {
    const auto* imu = std::get_if<ImuSample>(&m);
    if (imu == nullptr || imu->gyro.norm() <= fastest) continue;
    fastest = imu->gyro.norm();
    at = imu->t;
  }
  return at;
}

struct Walked {
  simulator::AnalyticWorld world;
  TimeNs begin = world.begin_time();
  Recording recording;

  explicit Walked(std::uint64_t seed, double seconds = 20) : world({.seed = seed}) {
    recording = record(*world.source(), world.begin_time() + to_ns(seconds));
  }
};

}  // namespace

TEST_CASE("bad IMU: spikes are refused, and cost nothing") {
  const std::string name = GENERATE(std::string("as_lio_plus"), std::string("fixed_window"));
  const Walked walk(101);
  Run clean(shipped(name), walk.world.sensor());
  clean.play(walk.recording);
  CHECK(clean.odometry.stream().counters().imu_found.spikes == 0);
  const TimeNs turn = sharpest_turn(walk.recording);
  for (const int n : {1, 3}) {
    for (const bool acc : {false, true}) {
      CAPTURE(name, n, acc);
      Recording recording = walk.recording;
      for (const TimeNs at : {walk.begin + to_ns(4.0), turn, walk.begin + to_ns(15.0)}) {
        recording = spoiled(std::move(recording), at, at + n * kSecond / 200,
                            [acc](ImuSample& s) { (acc ? s.acc : s.gyro).x() = acc ? 25 * kStandardGravity : 20; });
      }
      Run run(shipped(name), walk.world.sensor());
      run.play(recording);
      CHECK(run.odometry.stream().counters().imu_found.spikes == static_cast<std::uint64_t>(3 * n));
      CHECK(run.odometry.losses().empty());
      CHECK(error(run, walk.world) < 1.1 * error(clean, walk.world) + 1e-3);
    }
  }
}

TEST_CASE(
    "bad IMU: a gyro that ends at 2 rad/s in sharp turns is counted, and told where it was not declared") {  // eq.
                                                                                                             // MOT-12
  const std::string name = GENERATE(std::string("as_lio_plus"), std::string("fixed_window"));
  const bool declared = GENERATE(true, false);
  CAPTURE(name, declared);
  const Walked walk(102);
  const Recording recording =
      spoiled(walk.recording, kTimeMin, kTimeMax, [](ImuSample& s) { s.gyro = s.gyro.cwiseMax(-2.0).cwiseMin(2.0); });
  SensorModel sensor = walk.world.sensor();
  sensor.gyro_range = declared ? 2.0 : 0.0;
  Run run(shipped(name), sensor);
  run.play(recording);
  CHECK(run.odometry.stream().counters().imu_found.gyro_clipped > 100);
  CHECK(run.odometry.stream().warnings().empty() == declared);
  CAPTURE(error(run, walk.world), run.odometry.losses().size());
  CHECK((error(run, walk.world) < 0.5 || !run.odometry.losses().empty()));  // never wrong without a word
}

TEST_CASE("bad IMU: an accelerometer that ends at 1.1 g") {
  const double range = 1.1 * kStandardGravity;
  // One walk may have twice the error of another.
  double mean = 0;
  constexpr std::uint64_t kFirst = 103, kWalks = 3;
  for (std::uint64_t seed = kFirst; seed < kFirst + kWalks; ++seed) {
    CAPTURE(seed);
    const Walked walk(seed);
    const Recording recording = spoiled(walk.recording, kTimeMin, kTimeMax,
                                        [=](ImuSample& s) { s.acc = s.acc.cwiseMax(-range).cwiseMin(range); });
    SensorModel sensor = walk.world.sensor();
    sensor.acc_range = range;
    Run run(shipped("as_lio_plus"), sensor);
    run.play(recording);
    CHECK(run.odometry.stream().counters().imu_found.acc_clipped > 50);
    CHECK(run.odometry.losses().empty());
    CHECK(error(run, walk.world) < 1.0);
    mean += error(run, walk.world) / static_cast<double>(kWalks);
  }
  CHECK(mean < 0.6);
}

TEST_CASE("bad IMU: stuck or dead for a second is counted") {
  const std::string name = GENERATE(std::string("as_lio_plus"), std::string("fixed_window"));
  const bool zero = GENERATE(true, false);
  CAPTURE(name, zero);
  const Walked walk(104);
  const TimeNs at = walk.begin + to_ns(4.0);
  std::optional<ImuSample> held;
  const Recording recording = spoiled(walk.recording, at, at + kSecond, [&](ImuSample& s) {
    if (!held) held = s;
    s.gyro = zero ? Vec3(Vec3::Zero()) : held->gyro;
    s.acc = zero ? Vec3(Vec3::Zero()) : held->acc;
  });
  Run run(shipped(name), walk.world.sensor());
  run.play(recording);
  const auto& found = run.odometry.stream().counters().imu_found;
  CHECK((zero ? found.zero : found.stuck) >= 199);
  CHECK((zero ? found.stuck : found.zero) == 0);
  CAPTURE(error(run, walk.world), run.odometry.losses().size());
  CHECK((error(run, walk.world) < 0.5 || !run.odometry.losses().empty()));  // never wrong without a word
}

TEST_CASE("bad IMU: one that is dead from the beginning is refused by name") {
  const Walked walk(105, 1);
  const Recording recording = spoiled(walk.recording, kTimeMin, kTimeMax, [](ImuSample& s) {
    s.gyro.setZero();
    s.acc.setZero();
  });
  Run run(shipped("as_lio_plus"), walk.world.sensor());
  CHECK_THROWS_WITH(run.play(recording), Contains("the IMU is dead") && Contains("zero"));
}

TEST_CASE("bad IMU: zeros before the first reading are no readings") {
  const Walked walk(105, 3);
  const Recording recording = spoiled(walk.recording, kTimeMin, walk.begin + kSecond / 20, [](ImuSample& s) {
    s.gyro.setZero();
    s.acc.setZero();
  });
  Run run(shipped("as_lio_plus"), walk.world.sensor());
  run.play(recording);
  CHECK(run.odometry.losses().empty());
  CHECK(error(run, walk.world) < 0.05);
}

TEST_CASE("clocks: both jump: a loss with its reason, and a new start in time that goes on") {
  const TimeNs jump = GENERATE(-10 * kSecond, 3600 * kSecond);
  CAPTURE(jump);
  const Walked walk(106, 10);
  Run run(shipped("as_lio_plus"), walk.world.sensor());
  run.play(moved(walk.recording, walk.begin + 5 * kSecond, jump));
  REQUIRE(run.odometry.losses().size() == 1);
  CHECK_THAT(run.odometry.losses()[0].reason,
             Contains(jump < 0 ? "jumped back by 10.0 s" : "jumped ahead by 3600.0 s"));
  CHECK(run.odometry.losses()[0].restarted);
  CHECK(run.odometry.stream().counters().clock_jumps == 1);
  CHECK(run.odometry.tracking() == TrackingStatus::ok);
  for (std::size_t i = 1; i < run.updates.size(); ++i) REQUIRE(run.updates[i].plan.end > run.updates[i - 1].plan.end);
  CHECK(run.updates.back().plan.end > walk.begin + to_ns(9.5));
}

TEST_CASE("clocks: one that jumps alone is an error that names it") {
  const Walked walk(106, 9);
  Recording recording =
      spoiled(walk.recording, walk.begin + 5 * kSecond, kTimeMax, [](ImuSample& s) { s.t -= 10 * kSecond; });
  Run run(shipped("as_lio_plus"), walk.world.sensor());
  CHECK_THROWS_WITH(run.play(recording), Contains("IMU clock jumped back by 10.0 s"));
}

TEST_CASE("an empty scan, and one of a few points, are no fault of a run") {
  const std::string name = GENERATE(std::string("as_lio_plus"), std::string("fixed_window"));
  const std::size_t left = GENERATE(0, 1, 10);
  CAPTURE(name, left);
  const Walked walk(107, 8);
  for (const double at : {4.0, 4.03, 4.07}) {  // wherever windows begin
    Recording recording = walk.recording;
    for (Measurement& m : recording) {
      auto* packet = std::get_if<LidarPacket>(&m);
      if (packet == nullptr || std::abs(packet->stamp - walk.begin - to_ns(at)) > kSecond / 20) continue;
      packet->points.resize(std::min(left, packet->points.size()));
    }
    Run run(shipped(name), walk.world.sensor());
    run.play(recording);
    CHECK(run.odometry.stream().counters().empty_packets == (left == 0 ? 1 : 0));
    for (const auto& u : run.updates) {
      if (u.plan.end > walk.begin + kSecond) CHECK(u.tracking == TrackingStatus::ok);
      CHECK((u.status == UpdateStatus::few_matches) == u.without_view);
    }
  }
}
