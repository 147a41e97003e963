#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "aslio/core/errors.hpp"
#include "aslio/stream/measurement_stream.hpp"
#include "stream/stream_data.hpp"

using namespace aslio;
using namespace aslio::test;
using stream::kMaxForce;
using stream::kMaxRate;
using stream::MeasurementStream;

namespace {

constexpr TimeNs kPeriod = 5'000'000;

std::vector<ImuSample> regular_imu(int count) {
  std::vector<ImuSample> out;
  for (int i = 0; i < count; ++i) out.push_back(imu(kEpoch + i * kPeriod, i));
  return out;
}

bool same(std::span<const ImuSample> a, std::span<const ImuSample> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ImuSample& l, const ImuSample& r) {
    return l.t == r.t && l.gyro == r.gyro && l.acc == r.acc;
  });
}

}  // namespace

TEST_CASE("jittered, swapped and repeated IMU samples come out sorted, the first of equal stamps kept") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::mt19937_64 random(seed);
    std::map<TimeNs, double> oracle;
    MeasurementStream stream;
    std::uint64_t duplicates = 0;
    for (int i = 0; i < 500; ++i) {
      const TimeNs t = kEpoch + i * 1000 + pick(random, -2500, 2500) / 100 * 100;
      stream.push(imu(t, i));
      duplicates += !oracle.emplace(t, i).second;
    }
    const auto samples = stream.imu(kTimeMin, kTimeMax);
    REQUIRE(samples.size() == oracle.size());
    std::size_t k = 0;
    for (const auto& [t, value] : oracle) {
      REQUIRE(samples[k].t == t);
      REQUIRE(samples[k++].gyro.x() == value);
    }
    CHECK(stream.counters().imu == oracle.size());
    CHECK(stream.counters().imu_duplicate == duplicates);
    CHECK(stream.counters().imu_reordered > 100);
    CHECK(stream.imu_until() == oracle.rbegin()->first);
    CHECK(*stream.first_imu() == oracle.begin()->first);
  }
}

TEST_CASE("single faults leave the same samples as the clean recording") {
  const std::vector<ImuSample> clean = regular_imu(100);
  MeasurementStream reference;
  for (const ImuSample& s : clean) reference.push(s);
  const auto expected = reference.imu(kTimeMin, kTimeMax);

  MeasurementStream stream;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    if (i == 20) {
      ImuSample bad = imu(clean[i].t - 100, 99);
      bad.gyro.y() = std::nan("");
      stream.push(bad);
      bad = imu(clean[i].t - 100, 99);
      bad.acc.z() = std::numeric_limits<double>::infinity();
      stream.push(bad);
      stream.push(imu(kTimeMax, 99));
    }
    if (i == 30) stream.push(imu(clean[i].t - 5 * kSecond, 99));
    if (i == 40) stream.push(imu(clean[i].t + 3600 * kSecond, 99));
    if (i == 50) stream.push(imu(clean[i - 1].t, 99));
    if (i == 60) stream.push(imu(clean[i].t + 5 * kSecond, 99));
    stream.push(clean[i]);
  }
  CHECK(same(stream.imu(kTimeMin, kTimeMax), expected));
  CHECK(stream.counters().imu_invalid == 3);
  CHECK(stream.counters().imu_time_jumps == 3);
  CHECK(stream.counters().longest_imu_step == kPeriod);
  CHECK(stream.counters().imu_duplicate == 1);
  CHECK(stream.counters().imu_gaps == 0);
  CHECK(stream.counters().imu == 100);
}

TEST_CASE("a clock that really jumped ends the run with a reason") {
  for (const TimeNs jump : {-10 * kSecond, 3600 * kSecond}) {
    MeasurementStream stream;
    for (const ImuSample& s : regular_imu(201)) stream.push(s);
    const TimeNs begin = kEpoch + kSecond + jump;
    stream.push(imu(begin));
    stream.push(imu(begin + kPeriod));
    CHECK(stream.last_imu() == kEpoch + kSecond);
    CHECK_THROWS_AS(stream.push(imu(begin + 2 * kPeriod)), DataError);
    CHECK(stream.counters().imu_time_jumps == 3);
  }
  MeasurementStream stream;
  for (const ImuSample& s : regular_imu(201)) stream.push(s);
  const TimeNs back = kEpoch - 9 * kSecond;
  stream.push(imu(back));
  stream.push(imu(back + kPeriod));
  CHECK_THROWS_WITH(stream.push(imu(back + 2 * kPeriod)),
                    "IMU clock jumped back by 10.0 s at 1700000001.000000000 s (3 stamps in a row agree); split the "
                    "recording there");
}

TEST_CASE("a pause of up to a minute is believed once two more samples confirm it, and loses none") {
  for (const TimeNs pause : {kSecond + 1, 5 * kSecond, 60 * kSecond}) {
    MeasurementStream stream;
    stream.push(imu(kEpoch));
    stream.push(imu(kEpoch + pause));
    CHECK(stream.last_imu() == kEpoch);
    stream.push(imu(kEpoch + pause + kPeriod));
    CHECK(stream.last_imu() == kEpoch);
    stream.push(imu(kEpoch + pause + 2 * kPeriod));
    CHECK(stream.last_imu() == kEpoch + pause + 2 * kPeriod);
    CHECK(stream.imu(kTimeMin, kTimeMax).size() == 4);
    CHECK(stream.counters().longest_imu_step == pause);
    stream.push(imu(kEpoch + 2 * pause + 2 * kPeriod));  // one pause after another
    stream.push(imu(kEpoch + 3 * pause + 2 * kPeriod));
    stream.push(imu(kEpoch + 3 * pause + 3 * kPeriod));
    CHECK(stream.imu(kTimeMin, kTimeMax).size() == 7);
    CHECK(stream.counters().imu_time_jumps == 0);
    stream.push(imu(kEpoch + 5 * pause));
    stream.push(imu(kEpoch + 5 * pause + kPeriod));
    stream.finish();  // nothing confirms the last ones
    CHECK(stream.imu(kTimeMin, kTimeMax).size() == 7);
    CHECK(stream.counters().imu_time_jumps == 2);
  }
}

TEST_CASE("two samples with wild stamps of one time are dropped, and the run goes on") {
  for (const TimeNs by : {2 * kSecond, 60 * kSecond}) {
    MeasurementStream stream;
    for (const ImuSample& s : regular_imu(100)) {
      const bool wild = s.t == kEpoch + 50 * kPeriod || s.t == kEpoch + 51 * kPeriod;
      stream.push(imu(s.t + (wild ? by : 0)));
    }
    CHECK(stream.counters().imu == 98);
    CHECK(stream.counters().imu_time_jumps == 2);
    CHECK(stream.last_imu() == kEpoch + 99 * kPeriod);
  }
}

TEST_CASE("IMU data of which every sample comes twice are judged like others") {
  MeasurementStream stream;
  const auto twice = [&](TimeNs t) {
    stream.push(imu(t));
    stream.push(imu(t));
  };
  for (int i = 0; i < 10; ++i) twice(kEpoch + i * kPeriod);
  twice(kEpoch + 30 * kSecond);  // a wild stamp
  for (int i = 10; i < 20; ++i) twice(kEpoch + i * kPeriod);
  CHECK(stream.counters().imu == 20);
  CHECK(stream.counters().imu_time_jumps == 1);
  CHECK(stream.counters().imu_duplicate == 21);
  twice(kEpoch - 20 * kSecond);
  twice(kEpoch - 20 * kSecond + kPeriod);
  CHECK_THROWS_WITH(stream.push(imu(kEpoch - 20 * kSecond + 2 * kPeriod)), Catch::StartsWith("IMU clock jumped back"));
}

TEST_CASE("the last IMU sample after a pause is taken where points reach there") {
  for (const bool reached : {true, false}) {
    MeasurementStream stream;
    stream.push(imu(kEpoch));
    LidarPacket packet;
    TimedPoint point;
    point.t = kEpoch + (reached ? 5 : 3) * kSecond;
    packet.points.push_back(point);
    stream.push(std::move(packet));
    stream.push(imu(kEpoch + 5 * kSecond));
    stream.finish();
    CHECK(stream.counters().imu == (reached ? 2 : 1));
    CHECK(stream.counters().imu_time_jumps == (reached ? 0 : 1));
  }
}

TEST_CASE("wild stamps that do not agree with each other never end a run") {
  MeasurementStream stream;
  std::mt19937_64 random(1);
  for (const ImuSample& s : regular_imu(100)) stream.push(s);
  for (int i = 0; i < 100; ++i) stream.push(imu(kEpoch - (i + 1) * 2 * kSecond));
  CHECK(stream.counters().imu_time_jumps == 100);
  CHECK(stream.counters().imu == 100);
}

TEST_CASE("the IMU period is the median of recent steps, whatever single steps do") {
  MeasurementStream stream;
  CHECK(stream.imu_period() == 0);
  TimeNs t = kEpoch;
  std::mt19937_64 random(2);
  for (int i = 0; i < 400; ++i) {
    t += i % 50 == 49 ? 20 * kPeriod : kPeriod;
    stream.push(imu(t + pick(random, -400'000, 400'000)));
  }
  CHECK(std::abs(stream.imu_period() - kPeriod) < 200'000);
  CHECK(stream.counters().imu_gaps == 8);
}

TEST_CASE("samples before the last cut are late") {
  MeasurementStream stream;
  for (const ImuSample& s : regular_imu(10)) stream.push(s);
  WindowPlan plan;
  plan.history_begin = plan.fresh_begin = kEpoch;
  plan.end = kEpoch + 6 * kPeriod + 10;
  stream.cut(plan, 1);
  stream.push(imu(plan.end - 5));
  stream.push(imu(plan.end));
  stream.push(imu(plan.end + 5));
  CHECK(stream.counters().imu_late == 2);
  CHECK(stream.counters().imu_reordered == 1);
  CHECK(stream.imu(plan.end - 10, kTimeMax).size() == 4);
}

TEST_CASE("a window's IMU starts and ends at its ends, linear between samples") {
  MeasurementStream stream;
  std::vector<ImuSample> out{imu(1)};
  stream.imu_covering(kEpoch, kEpoch + 1, out);
  CHECK(out.empty());
  for (const ImuSample& s : regular_imu(20)) stream.push(s);
  stream.imu_covering(kEpoch + kPeriod / 2, kEpoch + 3 * kPeriod + kPeriod / 4, out);
  REQUIRE(out.size() == 5);
  const double values[] = {0.5, 1, 2, 3, 3.25};
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(out[i].t == kEpoch + to_ns(values[i] * 5e-3));
    CHECK(out[i].gyro.x() == Approx(values[i]).margin(1e-12));
    CHECK(out[i].acc.y() == Approx(values[i]).margin(1e-12));
  }
  stream.imu_covering(kEpoch + kPeriod, kEpoch + 3 * kPeriod, out);  // ends on samples
  REQUIRE(out.size() == 3);
  CHECK((out[0].gyro.x() == 1 && out[2].gyro.x() == 3));
  stream.imu_covering(kEpoch + 10, kEpoch + 20, out);  // inside one step
  REQUIRE(out.size() == 2);
  CHECK(out[1].gyro.x() == Approx(4e-6));
}

TEST_CASE("the specific force of a window is scaled where asked, readings stay as read") {  // eq. INI-7
  MeasurementStream stream;
  for (const ImuSample& s : regular_imu(20)) stream.push(s);
  std::vector<ImuSample> before, after;
  stream.imu_covering(kEpoch + kPeriod / 2, kEpoch + 3 * kPeriod, before);
  stream.scale_specific_force(0.5);
  stream.imu_covering(kEpoch + kPeriod / 2, kEpoch + 3 * kPeriod, after);
  REQUIRE(before.size() == after.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    CHECK(after[i].acc == 0.5 * before[i].acc);
    CHECK(after[i].gyro == before[i].gyro);
  }
  CHECK(stream.imu(kEpoch, kEpoch + 2 * kPeriod).back().acc.y() == Approx(2.0));
}

TEST_CASE("an IMU that lags behind the points is waited for as long as was asked, and no longer") {
  MeasurementStream stream;
  const auto point_at = [&](TimeNs t) {
    TimedPoint point;
    point.t = t;
    LidarPacket packet;
    packet.stamp = t;
    packet.points.push_back(point);
    stream.push(std::move(packet));
  };
  stream.push(ImuSample{kSecond, Vec3::Zero(), Vec3::Zero()});
  stream.push(ImuSample{2 * kSecond, Vec3::Zero(), Vec3::Zero()});
  point_at(9 * kSecond);
  CHECK(stream.imu_until() == 2 * kSecond);
  stream.wait_for_imu(5 * kSecond);
  CHECK(stream.imu_until() == 4 * kSecond);
  stream.push(ImuSample{6 * kSecond - 2 * kPeriod, Vec3::Zero(), Vec3::Zero()});
  stream.push(ImuSample{6 * kSecond - kPeriod, Vec3::Zero(), Vec3::Zero()});
  CHECK(stream.imu_until() == 4 * kSecond);  // a pause or a wild stamp: the next ones tell
  stream.push(ImuSample{6 * kSecond, Vec3::Zero(), Vec3::Zero()});
  CHECK(stream.imu_until() == 6 * kSecond);
  CHECK(stream.imu_silent_after(1, kTimeMax, 3 * kSecond) == 2 * kSecond);
  CHECK(stream.imu_silent_after(1, 2 * kSecond, 3 * kSecond) == std::nullopt);  // it lies behind
  CHECK(stream.imu_silent_after(3 * kSecond, 4 * kSecond, 3 * kSecond) == 2 * kSecond);
  CHECK(stream.imu_silent_after(6 * kSecond, 7 * kSecond, 3 * kSecond) == std::nullopt);  // the points are at 9 s
  CHECK(stream.imu_silent_after(6 * kSecond, 7 * kSecond, 3 * kSecond - 1) == 6 * kSecond);
  CHECK(stream.imu_silent_after(1, kTimeMax, 4 * kSecond) == std::nullopt);
}

TEST_CASE("missing IMU data is held or bridged") {
  MeasurementStream stream;
  std::vector<ImuSample> out;
  for (const ImuSample& s : regular_imu(40))
    if (s.gyro.x() < 20 || s.gyro.x() >= 30) stream.push(s);
  CHECK(stream.counters().imu_gaps == 1);
  stream.imu_covering(kEpoch - 100, kEpoch + kPeriod, out);
  CHECK((out.front().t == kEpoch - 100 && out.front().gyro.x() == 0));
  stream.imu_covering(kEpoch + 39 * kPeriod - 1, kEpoch + 50 * kPeriod, out);
  CHECK((out.back().t == kEpoch + 50 * kPeriod && out.back().gyro.x() == 39));
  stream.imu_covering(kEpoch + 100 * kPeriod, kEpoch + 101 * kPeriod, out);
  REQUIRE(out.size() == 2);
  CHECK((out[0].gyro.x() == 39 && out[1].t == kEpoch + 101 * kPeriod));
  // Windows that begin, end or lie in the gap, or span it.
  stream.imu_covering(kEpoch + 22 * kPeriod, kEpoch + 24 * kPeriod, out);
  CHECK(out[1].gyro.x() == Approx(24));
  stream.imu_covering(kEpoch + 10 * kPeriod, kEpoch + 35 * kPeriod, out);
  CHECK(out.size() == 16);  // 10 to 19 and 30 to 35
}

TEST_CASE("a first sample with a wild stamp is forgotten once three others agree against it") {
  for (const TimeNs first : {TimeNs{0}, kEpoch + 5 * kSecond, kEpoch + 3600 * kSecond}) {
    CAPTURE(first);
    MeasurementStream stream;
    stream.push(imu(first));
    for (const ImuSample& s : regular_imu(100)) stream.push(s);
    CHECK(stream.first_imu() == kEpoch + 2 * kPeriod);
    CHECK(stream.last_imu() == kEpoch + 99 * kPeriod);
    CHECK(stream.counters().imu == 98);
    CHECK(stream.counters().imu_time_jumps == 3);
    CHECK(stream.counters().longest_imu_step == kPeriod);
    // From then on a jump is a jump.
    const TimeNs back = kEpoch - 20 * kSecond;
    stream.push(imu(back));
    stream.push(imu(back + kPeriod));
    CHECK_THROWS_AS(stream.push(imu(back + 2 * kPeriod)), DataError);
  }
}

TEST_CASE("readings that no IMU can have are dropped and counted") {
  MeasurementStream stream;
  const double limits[2] = {kMaxRate, kMaxForce};
  for (int axis = 0; axis < 6; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      for (const double size : {1.0, 1e200}) {
        ImuSample sample = imu(kEpoch);
        (axis < 3 ? sample.gyro : sample.acc)[axis % 3] = sign * size * limits[axis / 3];
        stream.push(sample);
      }
    }
  }
  CHECK(stream.counters().imu_invalid == 24);
  CHECK(stream.counters().imu == 0);
  ImuSample hard = imu(kEpoch);
  hard.gyro.setConstant(0.99 * kMaxRate);
  hard.acc.setConstant(-0.99 * kMaxForce);
  stream.push(hard);
  CHECK(stream.counters().imu == 1);
}
