#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "aslio/stream/measurement_stream.hpp"
#include "stream/stream_data.hpp"

using namespace aslio;
using namespace aslio::test;
using stream::MeasurementStream;

namespace {

/// 6-point firings each 25 us; message ends may split a firing.
std::vector<LidarPacket> firings(std::mt19937_64& random, int packets) {
  std::vector<LidarPacket> out;
  int n = 0;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(packets); ++k) {
    std::vector<TimedPoint> points;
    for (TimeNs size = pick(random, 1, 2000); size > 0; --size, ++n)
      points.push_back(point(kEpoch + n / 6 * 25'000, k, static_cast<float>(n)));
    out.push_back(packet(k, std::move(points)));
  }
  return out;
}

WindowPlan plan_between(TimeNs begin, TimeNs end) {
  WindowPlan plan;
  plan.history_begin = plan.fresh_begin = begin;
  plan.end = end;
  return plan;
}

}  // namespace

TEST_CASE("consecutive cuts tile the stream and never split a firing") {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    std::mt19937_64 random(seed);
    MeasurementStream stream;
    TimeNs done = kEpoch - 1;
    std::set<TimeNs> cut_firings;
    float next = 0;
    std::uint32_t sequence = 0;
    const auto cut_until = [&](TimeNs limit) {
      while (true) {
        const TimeNs end = std::min(done + pick(random, 1, 9'000'000), stream.last_point());
        if (end > limit || end <= done) return;
        const Window window = stream.cut(plan_between(done, end), ++sequence);
        REQUIRE(window.sequence == sequence);
        for (const TimedPoint& p : window.fresh) {
          REQUIRE((p.t > done && p.t <= end));
          REQUIRE(p.x == next++);
        }
        if (!window.fresh.empty()) REQUIRE(cut_firings.insert(window.fresh.front().t).second);
        REQUIRE(window.imu.size() >= 2);
        REQUIRE(window.imu.front().t == done);
        REQUIRE(window.imu.back().t == end);
        for (std::size_t i = 1; i < window.imu.size(); ++i) REQUIRE(window.imu[i - 1].t < window.imu[i].t);
        done = end;
        if (random() % 3 == 0) stream.release(done - pick(random, 0, 5'000'000));
      }
    };
    for (int i = -1; i < 200; ++i) stream.push(imu(kEpoch + i * 5'000'000));
    for (LidarPacket& p : firings(random, 60)) {
      stream.push(std::move(p));
      cut_until(stream.points_until());
    }
    stream.finish();
    cut_until(stream.points_until());
    CHECK(static_cast<std::uint64_t>(next) == stream.counters().points);
    CHECK(stream.counters().points_late == 0);
  }
}

TEST_CASE("a cut at any time, also inside or between firings, keeps all six points together") {
  for (TimeNs offset = 0; offset < 100'000; offset += 1'771) {
    MeasurementStream stream;
    std::vector<TimedPoint> points;
    for (int n = 0; n < 60; ++n) points.push_back(point(kEpoch + n / 6 * 25'000));
    stream.push(packet(0, std::move(points)));
    stream.push(imu(kEpoch));
    const TimeNs end = kEpoch + 50'000 + offset;
    const Window window = stream.cut(plan_between(kEpoch - 1, end), 1);
    CHECK(window.fresh.size() == static_cast<std::size_t>((50'000 + offset) / 25'000 + 1) * 6);
    CHECK(stream.points(end, kTimeMax).size() + window.fresh.size() == 60);
    CHECK(window.imu.size() == 3);  // the only sample, and held at both ends
  }
}

TEST_CASE("a window without IMU data is empty of it") {
  MeasurementStream stream;
  stream.push(regular_packet(0, kEpoch, 1000, 10));
  const Window window = stream.cut(plan_between(kEpoch, kEpoch + 5000), 1);
  CHECK(window.imu.empty());
  CHECK(window.fresh.size() == 5);
}

TEST_CASE("release keeps the IMU sample from which the next window interpolates") {
  MeasurementStream stream;
  for (int i = 0; i < 10; ++i) stream.push(imu(kEpoch + i * 1000, i));
  stream.push(regular_packet(0, kEpoch, 100, 90));
  stream.cut(plan_between(kEpoch, kEpoch + 4500), 1);
  stream.release(kEpoch + 4500);
  CHECK(stream.buffered_imu() == 6);
  const Window window = stream.cut(plan_between(kEpoch + 4500, kEpoch + 6000), 2);
  CHECK(window.imu.front().gyro.x() == Approx(4.5));
  CHECK(window.imu_read_at_end);
  CHECK_FALSE(stream.cut(plan_between(kEpoch + 6000, kEpoch + 7500), 3).imu_read_at_end);
}

TEST_CASE("a window that reaches into a gap of the IMU knows how long that is, one beside it does not") {
  MeasurementStream stream;
  for (int i = 0; i < 40; ++i)
    if (i <= 20 || i >= 30) stream.push(imu(kEpoch + i * 1000, i));
  stream.push(regular_packet(0, kEpoch, 100, 600));
  const auto gap_of = [&](TimeNs begin, TimeNs end) {
    return stream.cut(plan_between(kEpoch + begin, kEpoch + end), 1).imu_gap;
  };
  CHECK(gap_of(17500, 19500) == 0);
  CHECK(gap_of(19500, 20000) == 0);      // up to its begin
  CHECK(gap_of(19500, 20100) == 10000);  // into it, inside it, over it, out of it
  CHECK(gap_of(21000, 23000) == 10000);
  CHECK(gap_of(19500, 31000) == 10000);
  CHECK(gap_of(29000, 31000) == 10000);
  CHECK(gap_of(30000, 33000) == 0);
  CHECK(gap_of(37500, 39500) == 0);     // half a period after the last reading
  CHECK(gap_of(37500, 45000) == 6000);  // and long after it
  CHECK(gap_of(50000, 51000) == 12000);
}

TEST_CASE("gaps of the IMU: before the first reading, after a release, of one reading and of none") {
  MeasurementStream none, one, many;
  for (MeasurementStream* stream : {&none, &one, &many}) stream->push(regular_packet(0, kEpoch, 100, 600));
  one.push(imu(kEpoch + 1000));
  for (int i = 10; i < 40; ++i)
    if (i <= 20 || i >= 30) many.push(imu(kEpoch + i * 1000, i));
  const auto gap_of = [&](MeasurementStream& stream, TimeNs begin, TimeNs end) {
    return stream.cut(plan_between(kEpoch + begin, kEpoch + end), 1).imu_gap;
  };
  CHECK(gap_of(none, 0, 5000) == 0);    // which then has no samples at all
  CHECK(gap_of(one, 500, 50000) == 0);  // what is usual is not known
  CHECK(gap_of(many, 2000, 15000) == 8000);
  many.release(kEpoch + 22000);
  CHECK(gap_of(many, 22000, 29000) == 10000);  // the reading before it is still there
}

TEST_CASE("whether a step of the IMU is a gap is in the data, not in what has arrived besides") {
  // A step of 5.2 ms among steps of 1 ms, and, later, steps of 2 ms.
  std::vector<TimeNs> times;
  for (TimeNs t = 0; t < 60'000; t += t == 30'000 ? 5200 : 1000) times.push_back(t);
  for (TimeNs t = 60'000; t < 300'000; t += 2000) times.push_back(t);
  const auto gaps = [&](std::size_t ahead) {
    MeasurementStream stream;
    stream.push(regular_packet(0, kEpoch, 100, 2900));
    std::vector<TimeNs> out;
    std::size_t next = 0;
    for (TimeNs end = 5000; end <= 55'000; end += 5000) {
      // As windows are cut: once a reading at their end or after it has arrived.
      for (; next < times.size() && (next < ahead || next == 0 || times[next - 1] < end); ++next) {
        stream.push(imu(kEpoch + times[next]));
      }
      out.push_back(stream.cut(plan_between(kEpoch + end - 5000, kEpoch + end), 1).imu_gap);
    }
    return out;
  };
  const auto late = gaps(0);
  CHECK(std::count(late.begin(), late.end(), 5200) == 2);
  CHECK(gaps(times.size()) == late);
}
