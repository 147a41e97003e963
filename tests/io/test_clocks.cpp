// Stamps that are damaged, and topics with the stamps of another clock.
#include <catch2/catch.hpp>

#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

constexpr TimeNs kHour = 3600 * kSecond;

/// The LiDAR messages with another stamp.
auto lidar_at(const std::function<TimeNs(int k, TimeNs stamp)>& change) {
  return [change](int k, TimeNs stamp) { return livox_message(change(k, stamp), change(k, stamp), 20); };
}

Recording imu_off(TimeNs by, double seconds = 6) {
  Recording recording;
  recording.seconds = seconds;
  recording.imu_stamp = [by](int, TimeNs stamp) { return stamp + by; };
  return recording;
}

std::string clock_refusal(const Recording& recording, const SensorConfig& sensor = {}) {
  TemporaryFolder folder;
  recording.write(folder / "a.bag");
  const std::string text = data_error([&] { open_source(folder / "a.bag", sensor); });
  const InputReport report = inspect(folder / "a.bag", sensor);
  CHECK(report.usable == text.empty());
  CHECK(report.reason == text);
  return text;
}

}  // namespace

TEST_CASE("a damaged first stamp moves no section and judges nothing") {
  for (const TimeNs first : {TimeNs{0}, kStart - kHour, kStart + kHour}) {
    for (const bool imu : {true, false}) {
      for (const bool lidar : {true, false}) {
        CAPTURE(first, imu, lidar);
        TemporaryFolder folder;
        Recording recording;
        recording.seconds = 4;
        if (imu) recording.imu_stamp = [first](int i, TimeNs stamp) { return i == 0 ? first : stamp; };
        // The time base stays.
        if (lidar) {
          recording.lidar = [first](int k, TimeNs stamp) { return livox_message(k == 0 ? first : stamp, stamp, 20); };
        }
        recording.write(folder / "a.bag");
        const auto source = open_source(folder / "a.bag", {}, {.start = 0.5, .duration = 1.0});
        CHECK(*source->begin_time() == kStart + kSecond / 2);
        CHECK(*source->end_time() == kStart + kSecond * 3 / 2);
        CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
        CHECK(contains(source->notes().verdicts, "ns from the time base"));
        CHECK(source->notes().warnings.empty());
        const Counts counts = drain(*source);
        CHECK(counts.imu == 100);
        CHECK(counts.packets == 10);
        const InputReport report = inspect(folder / "a.bag");
        CHECK(contains(report.topics[0].verdicts, "imu rate: 100.0 Hz"));
        CHECK(contains(report.topics[1].verdicts, "ns from the time base"));
        CHECK(drain(*open_source(folder / "a.bag", {})).imu == 400);
      }
    }
  }
}

TEST_CASE("a damaged stamp among those that are judged ends the judging of the IMU no sooner") {
  for (const auto& [damaged, ahead] : {std::pair(2, kHour), std::pair(250, 4 * kSecond)}) {
    CAPTURE(damaged, ahead);
    TemporaryFolder folder;
    Recording recording;
    recording.seconds = 6;
    recording.imu_stamp = [i = damaged, by = ahead](int k, TimeNs stamp) { return k == i ? stamp + by : stamp; };
    recording.turn = [](int i) { return Vec3(i == 400 ? 7.0 : 0.0, 0, 0); };
    recording.write(folder / "a.bag");
    const auto source = open_source(folder / "a.bag", {});
    CHECK(contains(source->notes().verdicts, "fastest 7.000 at the start"));
    CHECK(contains(source->notes().verdicts, "imu rate: 99.8 Hz"));
    CHECK(source->notes().warnings.empty());
    CHECK(contains(inspect(folder / "a.bag").topics[0].verdicts, "imu rate: 99.8 Hz"));
  }
}

TEST_CASE("stamps of one clock are taken as they are, whatever the recorder's clock or the times of a conversion") {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 8;
  recording.lidar = lidar_at([](int, TimeNs stamp) { return stamp; });
  SECTION("the clock of the sensors") {
    recording.recorded = [](TimeNs stamp) { return stamp - 1'000'000 * kSecond; };
  }
  SECTION("all recorded within a few microseconds") {
    recording.recorded = [](TimeNs stamp) { return kStart + (stamp - kStart) / 1'000'000; };
  }
  SECTION("a replay at a tenth of the speed") {
    recording.recorded = [](TimeNs stamp) { return kStart + 10 * (stamp - kStart); };
  }
  SECTION("a replay at ten times the speed") {
    recording.recorded = [](TimeNs stamp) { return kStart + (stamp - kStart) / 10; };
  }
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  CHECK(*source->begin_time() == kStart);
  CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
  CHECK(drain(*source).imu == 800);
  CHECK(drain(*open_source(folder / "a.bag", {}, {.start = 0, .duration = 1.0})).imu == 100);
}

TEST_CASE("topics with the stamps of two clocks are refused by name, with their offset") {
  const std::string late = clock_refusal(imu_off(-5 * kSecond));
  CHECK(contains(late, "the stamps of IMU topic '/livox/imu' and of LiDAR topic '/livox/lidar' are of clocks 5.000 s"));
  CHECK(contains(late, "lie 5.000 s before the times of recording, the latter 0.000 s before"));
  CHECK(contains(late, "those of '/livox/imu' look off: record both topics with one clock"));
  CHECK(contains(late, "correct these stamps by `imu_time_offset: 5.000` in the sensor file"));
  CHECK(contains(clock_refusal(imu_off(-kStart + 20 * kSecond)), "of clocks 1599999980.000 s apart"));
  CHECK(contains(late, "or take the times of recording by `stamps: received`"));
  Recording lidar;
  lidar.lidar = lidar_at([](int, TimeNs stamp) { return stamp + 3 * kSecond; });
  CHECK(contains(clock_refusal(lidar),
                 "the latter 3.000 s after the times of recording; those of '/livox/lidar' look off"));
}

TEST_CASE("clocks that are less apart, by what is known of the IMU, are accepted") {
  CHECK(clock_refusal(imu_off(kSecond * 9 / 10)).empty());
  SensorConfig sensor;
  sensor.imu_delay = 1;
  CHECK(contains(clock_refusal(imu_off(kSecond * 3 / 2)), "1.500 s apart (at most 1 s)"));
  CHECK(clock_refusal(imu_off(kSecond * 3 / 2), sensor).empty());
  CHECK(contains(clock_refusal(imu_off(-kSecond / 2), sensor), "1.500 s apart"));
  // A sweep of 1 s is recorded when it ends.
  Recording slow;
  slow.lidar = lidar_at([](int, TimeNs stamp) { return stamp - kSecond * 11 / 10; });
  CHECK_FALSE(clock_refusal(slow).empty());
  SensorConfig scanner;
  scanner.model.sweep_period = 1;
  CHECK(clock_refusal(slow, scanner).empty());
}

TEST_CASE("times of recording that tell nothing refuse no clocks") {
  Recording converted = imu_off(-5 * kSecond);
  converted.recorded = [](TimeNs) { return kStart; };
  CHECK(clock_refusal(converted).empty());
  // The first messages of the LiDAR came late, as its driver started.
  Recording starting;
  starting.seconds = 6;
  starting.lidar = lidar_at([](int k, TimeNs stamp) { return k < 8 ? stamp - 2 * kSecond : stamp; });
  CHECK(clock_refusal(starting).empty());
}

}  // namespace aslio::io::test
