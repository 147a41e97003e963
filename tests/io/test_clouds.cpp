// Every row of the table of PointCloud2 drivers, and clouds that must be refused.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/clouds.hpp"

namespace aslio::io::test {
namespace {

struct Driver {
  std::string name;
  std::function<Cloud(TimeNs)> make;
  TimeNs first;         ///< time of point 0 relative to the stamp [ns]
  TimeNs tolerance;     ///< resolution of the time field [ns]
  std::string verdict;  ///< part of the verdict
};

std::vector<Driver> drivers() {
  const auto absolute = [](TimeNs stamp, std::uint8_t step, std::uint32_t at, double per_second) {
    Cloud cloud;
    cloud.size(step);
    cloud.field("intensity", 12, kF32);
    if (at == 18) {
      cloud.field("tag", 16, kU8);
      cloud.field("line", 17, kU8);
    } else {
      cloud.field("ring", 16, kU16);
    }
    cloud.field("timestamp", at, kF64);
    for (int i = 0; i < kPoints; ++i) {
      const TimeNs t = stamp + offset_of(i);
      const double whole = static_cast<double>(t / kSecond), part = 1e-9 * static_cast<double>(t % kSecond);
      cloud.put(i, at, per_second == 1 ? whole + part : static_cast<double>(t));
    }
    return cloud;
  };
  return {
      {"velodyne, header of the last packet",
       [](TimeNs) {
         return with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i)) - 0.098); });
       },
       -98'000'000, 10, "of the last packet"},
      {"velodyne, header of the first packet",
       [](TimeNs) { return with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); }); }, 0,
       10, ", s, relative to the header stamp"},
      {"nclt, microseconds in a float",
       [](TimeNs) { return with_f32_time([](int i) { return static_cast<float>(1e-3 * double(offset_of(i))); }); }, 0,
       10, ", us, relative"},
      {"milliseconds in a float",
       [](TimeNs) { return with_f32_time([](int i) { return static_cast<float>(1e-6 * double(offset_of(i))); }); }, 0,
       10, ", ms, relative"},
      {"ouster, t",
       [](TimeNs) {
         Cloud cloud;
         cloud.size(48);
         cloud.field("intensity", 16, kF32);
         cloud.field("t", 20, kU32);
         cloud.field("reflectivity", 24, kU16);
         cloud.field("ring", 26, kU16);
         cloud.field("range", 32, kU32);
         for (int i = 0; i < kPoints; ++i) cloud.put(i, 20, static_cast<std::uint32_t>(offset_of(i)));
         for (int i = 0; i < kPoints; ++i) cloud.put(i, 26, static_cast<std::uint16_t>(i));
         return cloud;
       },
       0, 0, "'t' (uint32), ns, relative"},
      {"ouster, old driver with ring u8",
       [](TimeNs) {
         Cloud cloud;
         cloud.size(48);
         cloud.field("intensity", 16, kF32);
         cloud.field("t", 20, kU32);
         cloud.field("ring", 26, kU8);
         cloud.field("noise", 28, kU16);
         for (int i = 0; i < kPoints; ++i) cloud.put(i, 20, static_cast<std::uint32_t>(offset_of(i)));
         for (int i = 0; i < kPoints; ++i) cloud.put(i, 26, static_cast<std::uint8_t>(i));
         return cloud;
       },
       0, 0, "'t' (uint32), ns, relative"},
      {"hesai and robosense, absolute seconds", [=](TimeNs stamp) { return absolute(stamp, 26, 18 + 0, 1); }, 0, 300,
       ", s, absolute"},
      {"livox driver 2, absolute ns, unaligned", [=](TimeNs stamp) { return absolute(stamp, 26, 18, 1e9); }, 0, 256,
       ", ns, absolute"},
  };
}

}  // namespace

TEST_CASE("point times of every known driver") {
  for (const Driver& driver : drivers()) {
    INFO(driver.name);
    TemporaryFolder folder;
    recording_of(driver.make).write(folder / "a.bag");
    SensorConfig sensor;
    sensor.model.scan_lines = 128;
    const auto source = open_source(folder / "a.bag", sensor);
    CHECK(contains(source->notes().verdicts, driver.verdict));
    const LidarPacket packet = first_packet(*source);
    REQUIRE(packet.points.size() == kPoints);
    for (int i = 0; i < kPoints; ++i) {
      const TimeNs expected = kStart + driver.first + offset_of(i);
      REQUIRE(std::abs(packet.points[static_cast<std::size_t>(i)].t - expected) <= driver.tolerance);
    }
    CHECK(packet.points[7].x == 10.0F);
  }
}

TEST_CASE("every accepted name of a time field") {
  for (const std::string name : {"t", "time", "time_stamp", "timestamp", "timestamps", "offset_time"}) {
    INFO(name);
    TemporaryFolder folder;
    recording_of([&](TimeNs) {
      return with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); }, name);
    }).write(folder / "a.bag");
    CHECK(contains(open_source(folder / "a.bag", {})->notes().verdicts, fmt::format("'{}'", name)));
  }
}

TEST_CASE("ring numbers of either width are read") {
  for (const Driver& driver : drivers()) {
    if (!contains(driver.name, "ouster")) continue;
    TemporaryFolder folder;
    recording_of(driver.make).write(folder / "a.bag");
    CHECK(first_packet(*open_source(folder / "a.bag", {})).points[33].line == 33);
  }
}

TEST_CASE("times that cannot be known are refused, or taken from the header when that is asked for") {
  const auto untimed = [](TimeNs) {
    Cloud cloud;
    cloud.size(16);
    cloud.field("intensity", 12, kF32);
    return cloud;
  };
  struct Case {
    std::function<Cloud(TimeNs)> make;
    std::string reason;
  };
  const std::vector<Case> cases{
      {untimed, "no time field"},
      {[](TimeNs) { return with_f32_time([](int) { return 0.0F; }); }, "is 0 in all 50 points"},
      {[](TimeNs) { return with_f32_time([](int i) { return 50.0F * static_cast<float>(i); }); },
       "in none of s, ms, us, ns"},
      {[](TimeNs) { return with_f32_time([](int i) { return 77.0F + 0.002F * static_cast<float>(i); }); },
       "not of the IMU's clock either"},
      // An epoch in seconds does not fit a float: the field jumps by 128 s.
      {[](TimeNs stamp) {
         return with_f32_time([=](int i) { return static_cast<float>(1e-9 * double(stamp + offset_of(i))); });
       },
       "in all 50 points"},
  };
  for (const Case& one : cases) {
    INFO(one.reason);
    const Recording recording = recording_of(one.make);
    const std::string text = refusal(recording);
    CHECK(contains(text, one.reason));
    CHECK(contains(text, "require_point_times: false"));
    SensorConfig lenient;
    lenient.require_point_times = false;
    TemporaryFolder folder;
    recording.write(folder / "a.bag");
    const auto source = open_source(folder / "a.bag", lenient);
    CHECK(contains(source->notes().warnings, "no motion correction"));
    const LidarPacket packet = first_packet(*source);
    REQUIRE(packet.points.size() == kPoints);
    CHECK(packet.points.back().t == packet.stamp);
  }
}

TEST_CASE("a first cloud that is cut off, malformed, or has a damaged time does not speak for the topic") {
  const auto sweep = [](int) {
    return with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
  };
  struct Case {
    std::string what;
    std::function<std::vector<std::uint8_t>(TimeNs stamp)> first;
    int packets;
  };
  const auto damaged = [&](float time) {
    return [&sweep, time](TimeNs stamp) {
      Cloud cloud = sweep(0);
      cloud.put(7, 18, time);
      return cloud.message(stamp);
    };
  };
  const std::vector<Case> cases{
      {"cut off",
       [](TimeNs stamp) {
         // The last 5 ms of a sweep, as a driver that starts in the middle of one sends them: 0.05 of a sweep.
         return with_f32_time([](int i) { return 0.09F + 1e-4F * static_cast<float>(i); }).message(stamp);
       },
       5},
      {"one time of 5 s", damaged(5.0F), 5},
      {"one time of 12 s, a sweep in ms", damaged(12.0F), 5},
      {"malformed",
       [&](TimeNs stamp) {
         auto message = sweep(0).message(stamp);
         message.resize(message.size() / 2);
         return message;
       },
       4},
  };
  for (const Case& one : cases) {
    INFO(one.what);
    TemporaryFolder folder;
    Recording recording = recording_of(nullptr);
    recording.lidar = [&](int k, TimeNs stamp) { return k == 0 ? one.first(stamp) : sweep(k).message(stamp); };
    recording.write(folder / "a.bag");
    const auto source = open_source(folder / "a.bag", {});
    CHECK(contains(source->notes().verdicts, ", s, relative to the header stamp"));
    CHECK(drain(*source).packets == static_cast<std::size_t>(one.packets));
    if (one.packets < 5) continue;
    recording.seconds = 0.2;  // two clouds
    recording.write(folder / "b.bag");
    CHECK(contains(open_source(folder / "b.bag", {})->notes().verdicts, ", s, relative to the header stamp"));
  }
}

TEST_CASE("a later cloud with zero-filled times is skipped and counted") {
  TemporaryFolder folder;
  Recording recording = recording_of(nullptr);
  recording.lidar = [](int k, TimeNs stamp) {
    return with_f32_time([k](int i) { return k == 2 ? 0.0F : static_cast<float>(1e-9 * double(offset_of(i))); })
        .message(stamp);
  };
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  CHECK(drain(*source).packets == 4);
  CHECK(contains(source->notes().warnings, "same time"));
}

TEST_CASE("a later cloud without the time field, or with another type of it, is skipped and counted") {
  const auto sweep = [] {
    return with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
  };
  struct Case {
    std::string what;
    std::function<void(Cloud&)> change;
    std::size_t packets;
    std::string why;
  };
  const std::vector<Case> cases{
      {"renamed", [](Cloud& c) { c.layout.fields.back().name = std::string("time_q"); }, 6,
       "the first, of the LiDAR: it has no time field, which clouds before it have (fields: x float32"},
      {"another type", [](Cloud& c) { c.layout.fields.back().datatype = kU32; }, 6,
       "its time field 'time' is uint32, that of clouds before it float32"},
      {"renamed, without points",
       [](Cloud& c) {
         c.layout.fields.back().name = std::string("time_q");
         c.layout.width = c.layout.row_step = 0;
         c.data.clear();
       },
       8, ""},
  };
  for (const Case& one : cases) {
    INFO(one.what);
    for (const bool required : {true, false}) {
      TemporaryFolder folder;
      Recording recording = recording_of(nullptr);
      recording.seconds = 0.8;
      recording.lidar = [&](int k, TimeNs stamp) {
        Cloud cloud = sweep();
        if (k == 5 || k == 7) one.change(cloud);
        return cloud.message(stamp);
      };
      recording.write(folder / "a.bag");
      SensorConfig sensor;
      sensor.require_point_times = required;
      const auto source = open_source(folder / "a.bag", sensor);
      CHECK(drain(*source).packets == one.packets);
      CHECK(source->notes().malformed_lidar == 8 - one.packets);
      CHECK((one.why.empty() || contains(source->notes().warnings, one.why)));
      CHECK(inspect(folder / "a.bag", sensor).topics[1].malformed == 8 - one.packets);
    }
  }
}

TEST_CASE("points that are no returns are dropped and counted") {
  TemporaryFolder folder;
  recording_of([](TimeNs) {
    Cloud cloud = with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
    for (int i = 0; i < 10; ++i) cloud.put(i, 0, std::numeric_limits<float>::quiet_NaN());
    for (int i = 10; i < 15; ++i) cloud.put(i, 4, std::numeric_limits<float>::infinity());
    for (int i = 15; i < 20; ++i) cloud.put(i, 8, 1e30F);
    for (int i = 20; i < 25; ++i) {
      for (std::uint32_t axis = 0; axis < 12; axis += 4) cloud.put(i, axis, 0.0F);
    }
    cloud.put(25, 18, 3e9F);  // a time far outside
    cloud.put(26, 18, std::numeric_limits<float>::quiet_NaN());
    return cloud;
  }).write(folder / "a.bag");
  SensorConfig sensor;
  const LidarPacket damaged = first_packet(*open_source(folder / "a.bag", sensor));
  CHECK(damaged.points.size() == 23);
  CHECK(damaged.dropped_invalid == 27);
  recording_of([](TimeNs) {
    Cloud cloud = with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
    for (int i = 0; i < 25; ++i) cloud.put(i, 0, std::numeric_limits<float>::quiet_NaN());
    cloud.put(26, 18, std::numeric_limits<float>::quiet_NaN());
    return cloud;
  }).write(folder / "b.bag");
  const LidarPacket packet = first_packet(*open_source(folder / "b.bag", sensor));
  CHECK(packet.points.size() == 24);
  CHECK(packet.dropped_invalid == 26);
}

TEST_CASE("clouds whose sizes contradict each other are refused") {
  const auto broken = [](const std::function<void(Cloud&)>& damage) {
    return recording_of([damage](TimeNs) {
      Cloud cloud = with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
      damage(cloud);
      return cloud;
    });
  };
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.fields.back().offset = 20; })), "reach to byte 24"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.fields.back().offset = 0xFFFFFFFF; })), "reach to byte"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.fields.back().count = 0xFFFFFFFF; })), "reach to byte"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.fields.back().datatype = 9; })), "reach to byte 26"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.width += 1; })), "are there"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.height = 0xFFFFFFFF; })), "x 4294967295 points"));
  CHECK(contains(refusal(broken([](Cloud& c) {
                   c.layout.height = 2;
                   c.layout.row_step = 3;
                 })),
                 "row step"));
  CHECK(contains(refusal(broken([](Cloud& c) {
                   c.layout.height = 2;
                   c.layout.row_step = 0xFFFFFFFF;
                 })),
                 "are there"));
  CHECK(contains(refusal(broken([](Cloud& c) { c.layout.fields.front().name = std::string("u"); })), "no x, y, z"));
}

TEST_CASE("unsorted points are the same points") {
  TemporaryFolder folder;
  const auto make = [](bool reversed) {
    return recording_of([reversed](TimeNs) {
      return with_f32_time(
          [reversed](int i) { return static_cast<float>(1e-9 * double(offset_of(reversed ? 49 - i : i))); });
    });
  };
  make(true).write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  const LidarPacket packet = first_packet(*source);
  REQUIRE(packet.points.size() == kPoints);
  CHECK(std::abs(packet.points.front().t - (kStart + offset_of(49))) <= 10);
  CHECK(std::abs(packet.points.back().t - kStart) <= 10);
}

TEST_CASE("organised clouds with padded rows are read row by row") {
  TemporaryFolder folder;
  recording_of([](TimeNs) {
    Cloud cloud = with_f32_time([](int i) { return static_cast<float>(1e-9 * double(offset_of(i))); });
    std::vector<std::uint8_t> padded;
    for (std::size_t row = 0; row < 2; ++row) {
      const auto from = cloud.data.begin() + static_cast<std::ptrdiff_t>(row * 25 * 22);
      padded.insert(padded.end(), from, from + 25 * 22);
      padded.insert(padded.end(), 5, std::uint8_t{0xEE});
    }
    cloud.data = padded;
    cloud.layout.height = 2;
    cloud.layout.width = 25;
    cloud.layout.row_step = 25 * 22 + 5;
    return cloud;
  }).write(folder / "a.bag");
  const LidarPacket packet = first_packet(*open_source(folder / "a.bag", {}));
  REQUIRE(packet.points.size() == kPoints);
  CHECK(packet.points[49].x == 52.0F);
}

}  // namespace aslio::io::test
