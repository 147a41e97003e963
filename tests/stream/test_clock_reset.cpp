// A clock that jumps: that of both sensors, or of one.
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/stream/measurement_stream.hpp"
#include "stream/stream_data.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using stream::MeasurementStream;

namespace {

constexpr TimeNs kPeriod = 5'000'000, kSweep = 100'000'000;

/// From `begin` to `end` [s] of true time; from 2 s on the stamps of a sensor are off by its jump.
struct Recorder {
  TimeNs imu_jump = 0, lidar_jump = 0;
  MeasurementStream stream = MeasurementStream();

  void play(double begin, double end) {
    for (TimeNs t = to_ns(begin); t < to_ns(end); t += kPeriod) {
      stream.push(imu(kEpoch + t + (t >= 2 * kSecond ? imu_jump : 0)));
      if ((t + kPeriod) % kSweep != 0) continue;
      const TimeNs from = t + kPeriod - kSweep;
      const TimeNs stamp = kEpoch + from + (from >= 2 * kSecond ? lidar_jump : 0);
      stream.push(regular_packet(static_cast<std::uint32_t>(from / kSweep), stamp, kSweep / 100, 100));
    }
  }
};

}  // namespace

TEST_CASE("clock: both jump: what was there is forgotten, and time goes on") {
  for (const TimeNs jump : {-10 * kSecond, -2 * kSecond - 7, 3600 * kSecond}) {
    CAPTURE(jump);
    Recorder r{jump, jump};
    r.play(0, 2.1);
    const TimeNs before = r.stream.last_imu();
    r.play(2.1, 5);
    r.stream.finish();
    REQUIRE(r.stream.clock_jumps().size() == 1);
    CHECK(r.stream.counters().clock_jumps == 1);
    CHECK(std::abs(r.stream.clock_jumps()[0].by - jump) <= 2 * kPeriod);
    CHECK(r.stream.clock_jumps()[0].t >= before - kSweep);
    CHECK(std::abs(r.stream.clock_shift() + jump) <= 2 * kPeriod);
    CHECK(r.stream.points(kTimeMin, kEpoch + 2 * kSecond - kSweep).empty());
    CHECK(std::abs(r.stream.last_imu() - (kEpoch + 5 * kSecond - kPeriod)) <= 2 * kPeriod);
    CHECK(std::abs(r.stream.last_point() - (kEpoch + 5 * kSecond - kSweep / 100)) <= 2 * kPeriod);
    const auto samples = r.stream.imu(kTimeMin, kTimeMax);
    CHECK(samples.size() > 590);  // those of before serve nothing, since no window has been cut
    for (std::size_t i = 1; i < samples.size(); ++i) REQUIRE(samples[i].t > samples[i - 1].t);
    CHECK(r.stream.points(kTimeMin, kTimeMax).size() > 2600);
  }
}

TEST_CASE("clock: of one sensor alone: an error that names it, once the other has gone on for a second") {
  for (const bool of_imu : {true, false}) {
    for (const TimeNs jump : {-10 * kSecond, 3600 * kSecond}) {
      Recorder r{of_imu ? jump : 0, of_imu ? 0 : jump};
      CHECK_NOTHROW(r.play(0, 2.9));
      CHECK_THROWS_WITH(r.play(2.9, 6), Contains(of_imu ? "IMU clock jumped" : "LiDAR clock jumped") &&
                                            Contains(jump < 0 ? "back by" : "ahead by"));
    }
  }
}

TEST_CASE("clock: of both, by different times, is an error") {
  Recorder r{-10 * kSecond, -13 * kSecond};
  CHECK_THROWS_AS(r.play(0, 4), DataError);
}

TEST_CASE("clock: one that comes back has not jumped") {
  Recorder r;
  r.play(0, 2);
  r.imu_jump = -10 * kSecond;
  r.play(2, 2.2);
  r.imu_jump = 0;
  CHECK_NOTHROW(r.play(2.2, 6));
  CHECK(r.stream.clock_jumps().empty());
  CHECK(r.stream.counters().imu_time_jumps == 40);
}

TEST_CASE("clock: where nobody takes IMU data, that of the points alone decides") {
  MeasurementStream stream;
  stream.leave_imu_out();
  for (int i = 0; i < 40; ++i)
    stream.push(regular_packet(static_cast<std::uint32_t>(i), kEpoch + i * kSweep - (i >= 20 ? 10 * kSecond : 0),
                               kSweep / 100, 100));
  CHECK(stream.clock_jumps().size() == 1);
  CHECK(stream.last_point() > kEpoch + 39 * kSweep);
}

TEST_CASE("clock: it may jump again") {
  Recorder r{-10 * kSecond, -10 * kSecond};
  r.play(0, 4);
  r.imu_jump = r.lidar_jump = -30 * kSecond;
  r.play(4, 6);
  CHECK(r.stream.clock_jumps().size() == 2);
  CHECK(std::abs(r.stream.last_imu() - (kEpoch + 6 * kSecond)) <= 5 * kPeriod);
}
