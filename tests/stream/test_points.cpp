#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/stream/measurement_stream.hpp"
#include "stream/stream_data.hpp"

using namespace aslio;
using namespace aslio::test;
using stream::MeasurementStream;

namespace {

struct Expected {
  TimeNs t;
  float label;
};

/// Overlapping packets with shuffled, jittered and repeated times.
std::vector<LidarPacket> random_packets(std::mt19937_64& random, std::vector<Expected>& oracle) {
  std::vector<LidarPacket> packets;
  float label = 0;
  for (std::uint32_t k = 0; k < 30; ++k) {
    std::vector<TimedPoint> points;
    const TimeNs begin = kEpoch + k * 1000 - pick(random, 0, 300);
    for (TimeNs n = pick(random, 1, 200); n > 0; --n) {
      points.push_back(point(begin + pick(random, 0, 1000) / 6 * 6, k, ++label));
      oracle.push_back({points.back().t, label});
    }
    packets.push_back(packet(k, std::move(points)));
  }
  const auto earlier = [](const Expected& a, const Expected& b) { return a.t < b.t; };
  std::stable_sort(oracle.begin(), oracle.end(), earlier);
  return packets;
}

}  // namespace

TEST_CASE("points of shuffled, overlapping packets come out as a stable sort puts them") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<Expected> oracle;
    MeasurementStream stream;
    for (LidarPacket& p : random_packets(random, oracle)) stream.push(std::move(p));
    const auto points = stream.points(kTimeMin, kTimeMax);
    REQUIRE(points.size() == oracle.size());
    for (std::size_t i = 0; i < oracle.size(); ++i) {
      REQUIRE(points[i].t == oracle[i].t);
      REQUIRE(points[i].x == oracle[i].label);
    }
    CHECK(stream.counters().points == oracle.size());
    CHECK(stream.counters().points_reordered > 0);
    CHECK(*stream.first_point() == oracle.front().t);
    CHECK(stream.last_point() == oracle.back().t);

    const TimeNs from = kEpoch + pick(random, -500, 31000), to = from + pick(random, -10, 3000);
    std::size_t inside = 0;
    for (const Expected& e : oracle) inside += e.t > from && e.t <= to;
    CHECK(stream.points(from, to).size() == inside);
  }
}

TEST_CASE("a shuffled packet gives the same stream as the sorted one, indices included") {
  LidarPacket sorted = regular_packet(0, kEpoch, 4167, 5000);
  LidarPacket shuffled = sorted;
  std::mt19937_64 random(4);
  for (std::size_t i = shuffled.points.size() - 1; i > 0; --i)
    std::swap(shuffled.points[i], shuffled.points[random() % (i + 1)]);
  MeasurementStream a, b;
  a.push(std::move(sorted));
  b.push(std::move(shuffled));
  const auto left = a.points(kTimeMin, kTimeMax), right = b.points(kTimeMin, kTimeMax);
  REQUIRE(left.size() == right.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    CHECK(left[i].index == i);
    CHECK((left[i].t == right[i].t && left[i].x == right[i].x && left[i].index == right[i].index));
  }
  CHECK(a.counters().points_reordered == 0);
  CHECK(b.counters().points_reordered > 4000);
}

TEST_CASE("points that cannot be used are dropped and counted, each kind by itself") {
  MeasurementStream stream;
  LidarPacket p = regular_packet(0, kEpoch, 1000, 10);
  p.dropped_invalid = 7;
  p.points[1].x = std::numeric_limits<float>::quiet_NaN();
  p.points[2].y = std::numeric_limits<float>::infinity();
  p.points[3].z = 1e30F;
  p.points[4].t = kTimeMax;
  p.points[8].t += TimeNs{1} << 32;  // an offset that wrapped
  stream.push(std::move(p));
  CHECK(stream.counters().points_invalid == 11);
  CHECK(stream.counters().points_stray == 1);
  CHECK(stream.counters().points == 5);
  CHECK(stream.last_point() == kEpoch + 9000);

  stream.push(packet(1, {}));
  LidarPacket all_nan = regular_packet(2, kEpoch + 10000, 1000, 3);
  for (TimedPoint& q : all_nan.points) q.x = std::nanf("");
  stream.push(std::move(all_nan));
  CHECK(stream.counters().packets == 3);
  CHECK(stream.counters().empty_packets == 2);
  CHECK(stream.counters().points_invalid == 14);
  CHECK(stream.last_point() == kEpoch + 9000);
}

TEST_CASE("strays on both sides leave the body of the packet") {
  MeasurementStream stream;
  LidarPacket p = regular_packet(0, kEpoch, 1000, 100);
  p.points[0].t -= 5 * kSecond;
  p.points[98].t += 3 * kSecond;
  p.points[99].t += 5 * kSecond;
  stream.push(std::move(p));
  CHECK(stream.counters().points_stray == 3);
  CHECK(*stream.first_point() == kEpoch + 1000);
  CHECK(stream.last_point() == kEpoch + 97000);
}

TEST_CASE("a repeated packet is ignored, at once and after others") {
  MeasurementStream clean, repeated;
  const LidarPacket a = regular_packet(0, kEpoch, 1000, 50), b = regular_packet(1, kEpoch + 50000, 1000, 50);
  for (const LidarPacket* p : {&a, &b}) clean.push(LidarPacket(*p));
  for (const LidarPacket* p : {&a, &a, &b, &a, &b}) repeated.push(LidarPacket(*p));
  CHECK(repeated.counters().duplicate_packets == 3);
  CHECK(repeated.counters().points_reordered == 0);
  const auto left = clean.points(kTimeMin, kTimeMax), right = repeated.points(kTimeMin, kTimeMax);
  REQUIRE(left.size() == right.size());
  for (std::size_t i = 0; i < left.size(); ++i) CHECK((left[i].t == right[i].t && left[i].index == right[i].index));
}

TEST_CASE("points before the last cut are late, those after it that were let go are before the next start") {
  MeasurementStream stream;
  stream.push(regular_packet(0, kEpoch, 1000, 10));
  stream.push(imu(kEpoch));
  WindowPlan plan;
  plan.history_begin = plan.fresh_begin = kEpoch;
  plan.end = kEpoch + 5000;
  CHECK(stream.cut(plan, 1).fresh.size() == 5);
  stream.push(regular_packet(1, kEpoch + 3500, 1000, 3));  // 3500 and 4500 are late, 5500 is merged
  CHECK(stream.counters().points_late == 2);
  CHECK(stream.counters().points_reordered == 1);
  CHECK(stream.points(plan.end, kTimeMax).size() == 5);
  CHECK(stream.points(plan.end, kTimeMax)[0].t == kEpoch + 5500);
  stream.release(kEpoch + 8000);
  stream.push(packet(2, {point(kEpoch + 5000), point(kEpoch + 5001), point(kEpoch + 8000), point(kEpoch + 8001)}));
  CHECK(stream.counters().points_late == 3);
  CHECK(stream.counters().points_before_start == 2);
  CHECK(stream.buffered_points() == 2);
  plan.fresh_begin = plan.history_begin = kEpoch + 8000;
  plan.end = kEpoch + 9000;
  CHECK(stream.cut(plan, 2).fresh.size() == 2);  // 8001, and 9000 of the first packet
  stream.push(packet(3, {point(kEpoch + 4999), point(kEpoch + 7999), point(kEpoch + 8500)}));
  CHECK(stream.counters().points_late == 5);
  CHECK(stream.counters().points_before_start == 3);
}

TEST_CASE("what reaches back over the start is not late, whenever it comes") {
  MeasurementStream stream;
  stream.push(imu(kEpoch));
  stream.release(kEpoch + 5000);
  stream.push(regular_packet(0, kEpoch + 3000, 1000, 5));  // 3000, 4000 and 5000 are not after the start
  CHECK(stream.counters().points_before_start == 3);
  CHECK(stream.counters().points == 2);
  WindowPlan plan;
  plan.history_begin = plan.fresh_begin = kEpoch + 5000;
  plan.end = kEpoch + 7000;
  CHECK(stream.cut(plan, 1).fresh.size() == 2);
  stream.push(packet(1, {point(kEpoch + 4500), point(kEpoch + 6500), point(kEpoch + 7500)}));
  CHECK(stream.counters().points_before_start == 4);
  CHECK(stream.counters().points_late == 1);
  CHECK(stream.counters().points == 3);
}

TEST_CASE("one or two packets from another time do no harm, a third that agrees ends the run with a reason") {
  for (const TimeNs jump : {-10 * kSecond, 3600 * kSecond}) {
    MeasurementStream stream;
    const TimeNs step = kSecond / 10;
    for (std::uint32_t k = 0; k < 5; ++k) stream.push(regular_packet(k, kEpoch + k * step, 1000, 100));
    const TimeNs last = stream.last_point();
    stream.push(regular_packet(5, kEpoch + jump, 1000, 100));
    stream.push(regular_packet(6, kEpoch + jump + step, 1000, 100));
    CHECK(stream.last_point() == last);
    CHECK(stream.counters().points == 500);
    stream.push(regular_packet(7, kEpoch + 5 * step, 1000, 100));
    CHECK(stream.counters().points == 600);
    stream.push(regular_packet(8, kEpoch + jump, 999, 100));
    stream.push(regular_packet(9, kEpoch + jump + step, 999, 100));
    CHECK(stream.counters().packet_time_jumps == 4);
    const std::string expected =
        jump < 0 ? "LiDAR clock jumped back by 10.3 s" : "LiDAR clock jumped ahead by 3599.7 s";
    CHECK_THROWS_WITH(stream.push(regular_packet(10, kEpoch + jump + 2 * step, 999, 100)),
                      Catch::StartsWith(expected) && Catch::Contains("split the recording"));
    CHECK(stream.counters().packet_time_jumps == 5);
  }
}

TEST_CASE("a packet far ahead waits for the next two to tell a pause from a wild stamp") {
  const TimeNs step = kSecond / 10;
  MeasurementStream stream;
  stream.push(regular_packet(0, kEpoch, 1000, 100));
  stream.push(regular_packet(1, kEpoch + 5 * kSecond, 1000, 100));
  stream.push(regular_packet(2, kEpoch + step, 1000, 100));
  CHECK(stream.last_point() == kEpoch + step + 99'000);
  CHECK(stream.counters().points == 200);
  CHECK(stream.counters().packet_time_jumps == 1);
  CHECK(stream.counters().longest_point_step == step - 99'000);
  stream.push(regular_packet(3, kEpoch + 7 * kSecond, 1000, 100));
  CHECK(stream.counters().points == 200);
  stream.push(regular_packet(3, kEpoch + 7 * kSecond, 1000, 100));  // a copy confirms nothing
  CHECK(stream.counters().points == 200);
  CHECK(stream.counters().duplicate_packets == 1);
  for (int copy = 0; copy < 2; ++copy) stream.push(regular_packet(4, kEpoch + 7 * kSecond + step, 1000, 100));
  CHECK(stream.counters().points == 200);  // nor one of either
  CHECK(stream.counters().duplicate_packets == 2);
  stream.push(regular_packet(5, kEpoch + 7 * kSecond + 2 * step, 1000, 100));
  CHECK(stream.counters().points == 500);
  CHECK(stream.counters().packet_time_jumps == 1);
}

TEST_CASE("two packets with wild stamps of one time are dropped, and the run goes on") {
  const TimeNs step = kSecond / 10;
  MeasurementStream stream;
  for (std::uint32_t k = 0; k < 20; ++k) {
    const TimeNs wild = k == 10 || k == 11 ? 5 * kSecond : 0;
    stream.push(regular_packet(k, kEpoch + k * step + wild, 1000, 100));
  }
  CHECK(stream.counters().points == 1800);
  CHECK(stream.counters().packet_time_jumps == 2);
  CHECK(stream.last_point() == kEpoch + 19 * step + 99'000);
}

TEST_CASE("a first packet with a wild stamp is forgotten also where the IMU began long before") {
  const TimeNs step = kSecond / 10;
  MeasurementStream stream;
  for (int i = 0; i < 3; ++i) stream.push(imu(kEpoch - 20 * kSecond + i * kSecond));
  stream.release(kEpoch - 19 * kSecond);  // as while the points are waited for
  stream.push(regular_packet(7, kEpoch + 3600 * kSecond, 1000, 50));
  for (std::uint32_t k = 0; k < 6; ++k) stream.push(regular_packet(k, kEpoch + k * step, 1000, 100));
  CHECK(stream.counters().points == 400);
  CHECK(stream.first_point() == kEpoch + 2 * step);
}

TEST_CASE("a wild stamp that comes twice is a wild stamp, and a jump whose packets come twice a jump") {
  const TimeNs step = kSecond / 10;
  MeasurementStream stream;
  stream.push(regular_packet(0, kEpoch, 1000, 100));
  for (int copy = 0; copy < 2; ++copy) stream.push(regular_packet(1, kEpoch + 30 * kSecond, 1000, 100));
  for (std::uint32_t k = 1; k < 6; ++k) stream.push(regular_packet(k, kEpoch + k * step, 1000, 100));
  CHECK(stream.counters().points == 600);
  CHECK(stream.counters().packet_time_jumps == 1);
  const auto jumped = [&](std::uint32_t k) { return regular_packet(k, kEpoch - 20 * kSecond + k * step, 1000, 100); };
  for (std::uint32_t k = 0; k < 4; ++k) stream.push(jumped(k / 2));
  CHECK_THROWS_WITH(stream.push(jumped(2)), Catch::StartsWith("LiDAR clock jumped back by"));
}

TEST_CASE("the last packet after a pause is taken where IMU data reach there") {
  for (const TimeNs imu_end : {5 * kSecond, 3 * kSecond}) {
    MeasurementStream stream;
    stream.push(regular_packet(0, kEpoch, 1000, 100));
    for (TimeNs t = 0; t <= imu_end; t += kSecond / 2) stream.push(ImuSample{kEpoch + t, Vec3::Zero(), Vec3::Zero()});
    stream.push(regular_packet(1, kEpoch + 5 * kSecond, 1000, 100));
    stream.finish();
    const bool reached = imu_end == 5 * kSecond;
    CHECK(stream.counters().points == (reached ? 200 : 100));
    CHECK(stream.counters().packet_time_jumps == (reached ? 0 : 1));
  }
}

TEST_CASE("sweeps of points that were let go are let go, too") {
  MeasurementStream stream;
  for (std::uint32_t k = 0; k < 1000; ++k) {
    stream.push(regular_packet(k, kEpoch + k * (kSecond / 100), 1000, 10));
    stream.forget_points(stream.last_point() - kSecond);
  }
  CHECK(stream.buffered_points() < 1100);
  CHECK(stream.buffered_sweeps() < 110);
}

TEST_CASE("points are complete to just before the newest, since its firing may go on in the next packet") {
  MeasurementStream stream;
  CHECK(stream.points_until() == kTimeMin);
  CHECK(stream.last_point() == kTimeMin);
  stream.push(packet(0, {point(kEpoch), point(kEpoch + 25), point(kEpoch + 25)}));
  CHECK(stream.points_until() == kEpoch + 24);
  stream.push(packet(1, {point(kEpoch + 25), point(kEpoch + 50)}));
  CHECK(stream.points_until() == kEpoch + 49);
  CHECK(stream.points(kEpoch + 24, kEpoch + 25).size() == 3);
  stream.finish();
  CHECK(stream.points_until() == kTimeMax);
  CHECK(stream.imu_until() == kTimeMax);
}

TEST_CASE("the end of a sweep is known once a later one has begun") {
  MeasurementStream stream;
  CHECK_FALSE(stream.sweep_end_after(kEpoch));
  stream.push(regular_packet(0, kEpoch, 1000, 10));
  CHECK_FALSE(stream.sweep_end_after(kEpoch));
  stream.push(regular_packet(0, kEpoch + 10000, 1000, 10));  // a second message of the same revolution
  CHECK_FALSE(stream.sweep_end_after(kEpoch));
  LidarPacket mixed = regular_packet(1, kEpoch + 20000, 1000, 10);
  mixed.points.push_back(point(kEpoch + 30000, 2));
  stream.push(std::move(mixed));
  CHECK(*stream.sweep_end_after(kTimeMin) == kEpoch + 19000);
  CHECK(*stream.sweep_end_after(kEpoch + 18999) == kEpoch + 19000);
  CHECK(*stream.sweep_end_after(kEpoch + 19000) == kEpoch + 29000);
  CHECK_FALSE(stream.sweep_end_after(kEpoch + 29000));
  stream.release(kEpoch + 19000);
  CHECK(*stream.sweep_end_after(kTimeMin) == kEpoch + 29000);
  stream.finish();
  CHECK(*stream.sweep_end_after(kEpoch + 29000) == kEpoch + 30000);
  CHECK_FALSE(stream.sweep_end_after(kEpoch + 30000));
}

TEST_CASE("a first packet with a wild stamp is forgotten once three others agree against it") {
  const TimeNs step = kSecond / 10;
  for (const TimeNs first : {TimeNs{0}, kEpoch + 5 * kSecond, kEpoch + 3600 * kSecond}) {
    CAPTURE(first);
    MeasurementStream stream;
    stream.push(regular_packet(7, first, 1000, 50));
    for (std::uint32_t k = 0; k < 6; ++k) stream.push(regular_packet(k, kEpoch + k * step, 1000, 100));
    CHECK(stream.first_point() == kEpoch + 2 * step);
    CHECK(stream.last_point() == kEpoch + 5 * step + 99'000);
    CHECK(stream.points(kTimeMin, kTimeMax).size() == 400);
    CHECK(stream.counters().points == 400);
    CHECK(stream.counters().packet_time_jumps == 3);
    CHECK(stream.buffered_sweeps() == 4);
    CHECK(stream.counters().points_reordered == 0);
    CHECK(stream.settled() == false);  // no IMU yet
  }
}
