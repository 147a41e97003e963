#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "aslio/core/errors.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

/// A Livox message whose offsets go from 0 to `span` ns.
std::vector<std::uint8_t> spanning(TimeNs stamp, TimeNs span, int points = 100) {
  std::vector<rosbag::LivoxPoint> cloud(static_cast<std::size_t>(points), {0, 5, 0, 0, 10, 0x10, 0});
  for (int i = 0; i < points; ++i) {
    cloud[static_cast<std::size_t>(i)].offset_time = static_cast<std::uint32_t>(span * i / (points - 1));
  }
  std::vector<std::uint8_t> out;
  rosbag::encode_livox({0, stamp, ""}, stamp, 0, cloud, out);
  return out;
}

/// The same, in the unit of `per_ns` and moved, with the one in the middle replaced by `damaged` and the last few at
/// the end of the sweep.
std::vector<std::uint8_t> odd(TimeNs stamp, double per_ns, TimeNs moved, std::optional<TimeNs> damaged,
                              int points = 100, std::size_t last = 0) {
  std::vector<rosbag::LivoxPoint> cloud(static_cast<std::size_t>(points), {0, 5, 0, 0, 10, 0x10, 0});
  for (int i = 0; i < points; ++i) {
    const double offset = per_ns * 99e6 * i / (points - 1);
    cloud[static_cast<std::size_t>(i)].offset_time = static_cast<std::uint32_t>(offset + static_cast<double>(moved));
  }
  for (std::size_t i = 0; i < last; ++i) cloud[cloud.size() - 1 - i].offset_time = 99'000'000;
  if (damaged) cloud[cloud.size() / 2].offset_time = static_cast<std::uint32_t>(*damaged);
  std::vector<std::uint8_t> out;
  rosbag::encode_livox({0, stamp, ""}, stamp, 0, cloud, out);
  return out;
}

/// A message that claims more points than it has.
std::vector<std::uint8_t> claims_more(TimeNs stamp) {
  auto bytes = livox_message(stamp, stamp, 20);
  const std::uint32_t many = 1'000'000;
  std::memcpy(bytes.data() + 4 + 8 + 4 + 11 + 8 + 4 + 4, &many, 4);
  return bytes;
}

}  // namespace

TEST_CASE("livox messages of either package are read alike") {
  const auto type = GENERATE(as<const rosbag::MessageType*>{}, &rosbag::kLivoxCustomMsg, &rosbag::kLivox2CustomMsg);
  TemporaryFolder folder;
  Recording recording;
  recording.lidar_type = *type;
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  std::uint32_t sweep = 0;
  TimeNs last_imu = 0;
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      REQUIRE(packet->sweep_id == sweep);
      REQUIRE(packet->points.size() == 20);
      CHECK(packet->stamp == kStart + sweep * (kSecond / 10));
      CHECK(packet->points.front().t == packet->stamp);
      CHECK(packet->points.back().t == packet->stamp + 99'000'000);
      CHECK(packet->points[3].x == 8.0F);
      CHECK(packet->points[3].line == 3);
      CHECK(packet->points[3].tag == 0x10);
      CHECK(packet->points[3].intensity == 3.0F);
      CHECK(packet->points[3].sweep_id == sweep);
      ++sweep;
    } else {
      const TimeNs t = std::get<ImuSample>(*measurement).t;
      CHECK(t > last_imu);
      last_imu = t;
    }
  }
  CHECK(sweep == 20);
  CHECK(*source->begin_time() == kStart);
  CHECK(*source->end_time() == kStart + 199 * kSecond / 100);
}

TEST_CASE("topics are found by type, and errors list what is there") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar_topic = "/front/lidar";
  recording.imu_topic = "/front/imu";
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  CHECK(drain(*open_source(folder / "a.bag", sensor)).packets == 20);
  sensor.lidar_topic = "/livox/lidar";
  const std::string missing = data_error([&] { open_source(folder / "a.bag", sensor); });
  CHECK(contains(missing, "no LiDAR topic '/livox/lidar'"));
  CHECK(contains(missing, "/front/lidar [livox_ros_driver/CustomMsg]"));
  CHECK(contains(missing, "/front/imu [sensor_msgs/Imu]"));
  CHECK(contains(missing, "`lidar_topic`"));
  sensor.lidar_topic = "/front/imu";
  const std::string swapped = data_error([&] { open_source(folder / "a.bag", sensor); });
  CHECK(contains(swapped,
                 "LiDAR topic '/front/imu' is of type sensor_msgs/Imu: `lidar_topic` and `imu_topic` look swapped; "));
  CHECK_FALSE(contains(swapped, "another version"));
  sensor.lidar_topic = "/front/lidar";
  sensor.imu_topic = "/front/lidar";
  CHECK(contains(data_error([&] { open_source(folder / "a.bag", sensor); }),
                 "IMU topic '/front/lidar' is of type livox_ros_driver/CustomMsg: `lidar_topic` and `imu_topic` look"));
}

TEST_CASE("pipes and devices are refused by name before they are opened") {
  TemporaryFolder folder;
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const std::filesystem::path& path :
       {folder / "pipe", std::filesystem::path("/dev/zero"), std::filesystem::path("/dev/null")}) {
    const std::string expected = path.string() + ": is a pipe or device, not a regular file: copy the recording";
    CHECK(contains(data_error([&] { open_source(path, {}); }), expected));
    CHECK(contains(data_error([&] { inspect(path); }), expected));
    CHECK(contains(data_error([&] { input_digest(path); }), expected));
  }
}

TEST_CASE("two topics of a kind must be chosen between, none is named") {
  TemporaryFolder folder;
  std::vector<std::uint8_t> bytes;
  const auto write = [&](const std::string& name, bool imu, int lidars) {
    rosbag::BagWriter bag(folder / name);
    const auto add = [&](const std::string& topic, const rosbag::MessageType& type) {
      return bag.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
    };
    for (int k = 0; k < lidars; ++k) {
      bag.write(add("/lidar" + std::to_string(k), rosbag::kLivoxCustomMsg), kStart, livox_message(kStart, kStart, 5));
    }
    rosbag::encode_imu({0, kStart, ""}, Vec3::Zero(), Vec3(0, 0, 9.8), bytes);
    if (imu) bag.write(add("/imu", rosbag::kImu), kStart, bytes);
    bag.close();
  };
  write("two.bag", true, 2);
  write("no_imu.bag", false, 1);
  write("no_lidar.bag", true, 0);
  CHECK(contains(data_error([&] { open_source(folder / "two.bag", {}); }), "more than one LiDAR"));
  SensorConfig sensor;
  sensor.lidar_topic = "/lidar1";
  CHECK(drain(*open_source(folder / "two.bag", sensor)).packets == 1);
  CHECK(
      contains(data_error([&] { open_source(folder / "no_imu.bag", {}); }), "there is no IMU topic (sensor_msgs/Imu)"));
  CHECK(contains(data_error([&] { open_source(folder / "no_lidar.bag", {}); }), "there is no LiDAR"));
}

TEST_CASE("a message of a known name but another version is refused") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar_type.md5 = "00000000000000000000000000000000";
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.lidar_topic = "/livox/lidar";
  CHECK(contains(data_error([&] { open_source(folder / "a.bag", sensor); }), "another version"));
}

TEST_CASE("a section is taken by data time") {
  TemporaryFolder folder;
  Recording{}.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {}, {.start = 0.5, .duration = 1.0});
  CHECK(*source->begin_time() == kStart + kSecond / 2);
  CHECK(*source->end_time() == kStart + kSecond * 3 / 2);
  const auto first = source->next();
  REQUIRE(first);
  CHECK(std::get<ImuSample>(*first).t == kStart + kSecond / 2);
  const Counts rest = drain(*source);
  CHECK(rest.imu == 99);
  CHECK(rest.packets == 10);
  CHECK(
      contains(data_error([&] { open_source(folder / "a.bag", {}, {.start = 60, .duration = {}}); }), "starts at 60"));
  CHECK_THROWS_AS(open_source(folder / "a.bag", {}, {.start = -1, .duration = {}}), ConfigError);
}

TEST_CASE("livox points that are noise, of an unknown line, or no return are dropped and counted") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int, TimeNs stamp) {
    std::vector<rosbag::LivoxPoint> points(10, {1000, 5, 0, 0, 10, 0x10, 0});
    for (std::size_t i = 0; i < 10; ++i) points[i].offset_time = static_cast<std::uint32_t>(9'000'000 * i);
    points[1].tag = 0x20;
    points[2].tag = 0x30;
    points[3].tag = 0x0F;  // the lower bits speak of something else
    points[4].line = 6;
    points[5].x = std::numeric_limits<float>::quiet_NaN();
    points[6].x = 0;
    points[7].x = 1e30F;
    points[8].offset_time = 0xFFFFFF00;  // wrapped
    std::vector<std::uint8_t> out;
    rosbag::encode_livox({0, stamp, ""}, stamp, 0, points, out);
    return out;
  };
  recording.write(folder / "a.bag");
  const Counts counts = drain(*open_source(folder / "a.bag", {}));
  CHECK(counts.points == 3 * 20);
  CHECK(counts.dropped == 7 * 20);
  SensorConfig all;
  all.livox_tag_filter = false;
  CHECK(drain(*open_source(folder / "a.bag", all)).points == 5 * 20);
}

TEST_CASE("points of lines that the sensor file does not know are counted, and a warning names its key") {
  TemporaryFolder folder;
  for (const bool damaged : {false, true}) {
    Recording recording;
    recording.lidar = [damaged](int, TimeNs stamp) {
      std::vector<rosbag::LivoxPoint> points(120, {1000, 5, 0, 0, 10, 0x10, 0});
      for (std::size_t i = 0; i < 120; ++i) {
        points[i].offset_time = static_cast<std::uint32_t>(800'000 * i);
        points[i].line = static_cast<std::uint8_t>(i % 6);
      }
      if (damaged) points[4].x = points[5].x = 0;  // no returns, whatever their line
      std::vector<std::uint8_t> out;
      rosbag::encode_livox({0, stamp, ""}, stamp, 0, points, out);
      return out;
    };
    recording.write(folder / "a.bag");
    SensorConfig four;
    four.model.scan_lines = 4;
    const auto source = open_source(folder / "a.bag", four);
    std::size_t beyond = 0, packets = 0;
    while (const auto measurement = source->next()) {
      const auto* packet = std::get_if<LidarPacket>(&*measurement);
      if (packet == nullptr) continue;
      ++packets;
      beyond += packet->beyond_lines;
      CHECK(packet->highest_line == 5);
    }
    CHECK(beyond == (damaged ? 38 : 40) * packets);
    CHECK(contains(source->notes().warnings, "`scan_lines` is 4"));
    CHECK(contains(source->notes().warnings, "from 4 to 5"));
    const auto six = open_source(folder / "a.bag", {});
    drain(*six);
    CHECK_FALSE(contains(six->notes().warnings, "scan_lines"));
  }
}

TEST_CASE("empty and one-point scans are delivered, zero times are refused") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int k, TimeNs stamp) { return livox_message(stamp, stamp, k < 3 ? k : 20); };
  recording.write(folder / "a.bag");
  CHECK(drain(*open_source(folder / "a.bag", {})).packets == 20);
  recording.lidar = [](int, TimeNs stamp) {
    const std::vector<rosbag::LivoxPoint> points(10, {0, 5, 0, 0, 10, 0x10, 0});
    std::vector<std::uint8_t> out;
    rosbag::encode_livox({0, stamp, ""}, stamp, 0, points, out);
    return out;
  };
  recording.write(folder / "b.bag");
  CHECK(contains(data_error([&] { open_source(folder / "b.bag", {}); }), "offset_time is 0 in all 10 points"));
  SensorConfig lenient;
  lenient.require_point_times = false;
  CHECK(drain(*open_source(folder / "b.bag", lenient)).points == 200);
}

TEST_CASE("livox offsets of another unit are refused, or left alone when that is asked for") {
  const auto error = [](TimeNs span, double seconds = 2, const SensorConfig& sensor = {}) {
    TemporaryFolder folder;
    Recording recording;
    recording.seconds = seconds;
    recording.lidar = [span](int, TimeNs stamp) { return spanning(stamp, span); };
    recording.write(folder / "a.bag");
    const std::string text = data_error([&] { open_source(folder / "a.bag", sensor); });
    const InputReport report = inspect(folder / "a.bag", sensor);
    CHECK(report.usable == text.empty());
    REQUIRE(report.topics.size() == 2);
    CHECK(report.topics[1].problem == text);
    return text;
  };
  const std::string micro = error(100'000);
  CHECK(contains(micro,
                 "/livox/lidar: the time of the points cannot be known: the first 10 messages span 0.0001 s "
                 "(median) where `sweep_period` is 0.1 s (is offset_time in microseconds?)"));
  CHECK(contains(micro, "require_point_times: false"));
  CHECK(contains(error(100'000, 0.05), "the first message spans 0.0001 s where"));
  CHECK(contains(error(100'000, 0.5), "the first 5 messages span 0.0001 s (median)"));
  // Of a driver that sends 3 ms at a time; in milliseconds that would be 30 sweeps.
  CHECK(contains(error(3'000), "is offset_time in microseconds?"));
  CHECK(contains(error(100), "is offset_time in milliseconds?"));
  SensorConfig quick;
  quick.model.sweep_period = 0.0001;
  CHECK(contains(error(99'000'000, 2, quick), "is offset_time in ns, and `sweep_period` right?"));
  // Drivers send 10 ms at a time, too.
  CHECK(error(10'000'000).empty());
  CHECK(error(5'000'000).empty());
  // A 1/167 of the sweep is no other unit yet, a 1/250 is.
  CHECK(error(600'000).empty());
  CHECK(contains(error(400'000), "the first 10 messages span 0.0004 s (median)"));

  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int, TimeNs stamp) { return spanning(stamp, 100'000); };
  recording.write(folder / "a.bag");
  SensorConfig lenient;
  lenient.require_point_times = false;
  const auto source = open_source(folder / "a.bag", lenient);
  CHECK(contains(source->notes().warnings, "all points take the time base, no motion correction"));
  std::size_t packets = 0;
  while (const auto measurement = source->next()) {
    const auto* packet = std::get_if<LidarPacket>(&*measurement);
    if (packet == nullptr) continue;
    ++packets;
    REQUIRE(packet->points.size() == 100);
    CHECK(packet->points.back().t == packet->stamp);
  }
  CHECK(packets == 20);
}

TEST_CASE("first livox messages that are cut off or malformed do not speak for the topic") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int k, TimeNs stamp) {
    return k == 1 ? claims_more(stamp) : spanning(stamp, k < 4 ? 300'000 : 99'000'000);
  };
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  CHECK(contains(source->notes().verdicts, "livox offset_time, ns from the time base (0.000000 to 0.099000 s)"));
  CHECK(drain(*source).packets == 19);
  // Fewer points than tell: nothing is refused for them, and it is said.
  recording.lidar = [](int, TimeNs stamp) { return spanning(stamp, 100'000, 99); };
  recording.write(folder / "b.bag");
  CHECK(contains(open_source(folder / "b.bag", {})->notes().warnings, "no message has enough returns to judge"));
}

TEST_CASE("a damaged livox offset, or a message that fits, does not hide another unit") {
  const auto error = [](auto lidar) {
    TemporaryFolder folder;
    Recording recording;
    recording.lidar = lidar;
    recording.write(folder / "a.bag");
    return data_error([&] { open_source(folder / "a.bag", {}); });
  };
  const double micro = 1e-3;
  for (const int points : {100, 1000}) {
    for (const TimeNs damaged : {600'000'000LL, 4'000'000'000LL}) {
      CAPTURE(points, damaged);
      const std::string first = error(
          [&](int k, TimeNs t) { return odd(t, micro, 0, k == 0 ? std::optional(damaged) : std::nullopt, points); });
      CHECK(contains(first, "(is offset_time in microseconds?)"));
      CHECK(contains(error([&](int, TimeNs t) { return odd(t, micro, 0, damaged, points); }), "in microseconds?"));
      CHECK(error([&](int, TimeNs t) { return odd(t, 1, 0, damaged, points); }).empty());
    }
  }
  for (const int fitting : {1, 4}) {
    CHECK(contains(error([&](int k, TimeNs t) { return odd(t, k < fitting ? 1 : micro, 0, {}); }), "in microseconds?"));
  }
  CHECK(
      contains(error([](int, TimeNs t) { return odd(t, 0, 0, 600'000'000); }), "offset_time is 0 in 99 of 100 points"));
}

TEST_CASE("good livox messages are accepted, however short or sparse the first ones are") {
  const auto accepted = [](auto lidar) {
    TemporaryFolder folder;
    Recording recording;
    recording.seconds = 6;
    recording.lidar = lidar;
    recording.write(folder / "a.bag");
    const auto source = open_source(folder / "a.bag", {});
    return contains(source->notes().verdicts, "livox offset_time, ns") && drain(*source).packets == 60;
  };
  // 5 to 100 messages a second, at the sweep period of 0.1 s.
  for (const TimeNs span : {200'000'000, 99'000'000, 50'000'000, 20'000'000, 9'900'000}) {
    for (const int points : {4, 20, 101, 2000}) {
      CAPTURE(span, points);
      CHECK(accepted([&](int, TimeNs t) { return spanning(t, span, points); }));
    }
  }
  // Cut off by the start; without returns; and of one moment, as little as the view may show of it.
  for (const int n : {1, 3, 5}) {
    CAPTURE(n);
    CHECK(accepted([&](int k, TimeNs t) { return spanning(t, k < n ? 300'000 : 99'000'000); }));
  }
  CHECK(accepted([](int k, TimeNs t) { return livox_message(t, t, k < 45 ? k % 2 : 100); }));
  CHECK(accepted([](int k, TimeNs t) { return k < 30 ? spanning(t, 90'000, 99) : livox_message(t, t, 100); }));
  CHECK(accepted([](int k, TimeNs t) { return k < 30 ? odd(t, 4e-3, 0, {}, 110, 5) : livox_message(t, t, 100); }));
}

TEST_CASE("livox offsets that count from another moment are refused for that, or left alone when that is asked for") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int, TimeNs stamp) { return odd(stamp, 1, 2 * kSecond, {}); };
  recording.write(folder / "a.bag");
  const std::string refused = data_error([&] { open_source(folder / "a.bag", {}); });
  CHECK(contains(refused,
                 "offset_time goes from 2.000000 to 2.099000 s; more than 1 s after the time base is taken for damage "
                 "(does it count from another moment?); record with per-point times in ns from the time base, or set "
                 "`require_point_times: false`"));
  CHECK(inspect(folder / "a.bag").topics[1].problem == refused);
  SensorConfig lenient;
  lenient.require_point_times = false;
  CHECK(inspect(folder / "a.bag", lenient).topics[1].empty == 0);
  const auto source = open_source(folder / "a.bag", lenient);
  CHECK(contains(source->notes().warnings, "all points take the time base, no motion correction"));
  const Counts counts = drain(*source);
  CHECK(counts.points == 2000);
  CHECK(counts.dropped == 0);
  // Messages of 4 s, of a scanner of which 0.1 s is said: another sweep period makes them fit.
  recording.lidar = [](int, TimeNs stamp) { return spanning(stamp, 4 * kSecond); };
  recording.write(folder / "b.bag");
  const std::string slow = data_error([&] { open_source(folder / "b.bag", {}); });
  CHECK(contains(slow, "(is `sweep_period` right?); record with per-point times in ns, check `sweep_period`"));
  SensorConfig right;
  right.model.sweep_period = 4;
  CHECK(drain(*open_source(folder / "b.bag", right)).points == 2000);
}

TEST_CASE("malformed messages are skipped and counted, a malformed first one is refused") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int k, TimeNs stamp) {
    return k == 5 || k == 6 ? claims_more(stamp) : livox_message(stamp, stamp, 20);
  };
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  CHECK(source->notes().malformed_lidar + source->notes().malformed_imu == 0);
  CHECK_FALSE(contains(source->notes().warnings, "malformed"));
  CHECK(drain(*source).packets == 18);
  CHECK(source->notes().malformed_lidar + source->notes().malformed_imu == 2);
  CHECK(contains(source->notes().warnings, "2 malformed message(s) skipped"));
  CHECK(contains(source->notes().warnings, "claims 1000000 points"));
  recording.lidar = [](int, TimeNs stamp) { return claims_more(stamp); };
  recording.write(folder / "b.bag");
  CHECK(contains(data_error([&] { open_source(folder / "b.bag", {}); }), "first message cannot be decoded"));
}

TEST_CASE("a time base of another clock gives way to the header stamp") {
  TemporaryFolder folder;
  Recording recording;
  recording.timebase_shift = -1'500'000'000 * kSecond;
  recording.write(folder / "a.bag");
  const auto source = open_source(folder / "a.bag", {});
  CHECK(contains(source->notes().warnings, "time base and header stamp differ"));
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      REQUIRE(packet->points.front().t == packet->stamp);
    }
  }
}

TEST_CASE("inspection tells what is there and whether it can be used") {
  TemporaryFolder folder;
  Recording{}.write(folder / "a.bag");
  const InputReport report = inspect(folder / "a.bag");
  CHECK(report.usable);
  CHECK(report.kind == "ROS1 bag");
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[0].topic == "/livox/imu");
  CHECK(report.topics[0].messages == 200);
  CHECK(report.topics[0].rate == Approx(100));
  CHECK(report.topics[0].median_period == Approx(0.01));
  CHECK(report.topics[1].points_per_message == Approx(20));
  const std::string text = render(report);
  CHECK(contains(text, "usable: yes"));
  CHECK(contains(text, "livox_ros_driver/CustomMsg"));
  CHECK(contains(text, "m/s^2"));
  Recording still;
  still.acc = Vec3(0, 0, 3);
  still.write(folder / "b.bag");
  const InputReport refused = inspect(folder / "b.bag");
  CHECK_FALSE(refused.usable);
  CHECK(contains(refused.reason, "neither g"));
  CHECK(contains(render(refused), "CANNOT BE USED"));
}

TEST_CASE("inspection counts gaps and backward stamps") {
  TemporaryFolder folder;
  {
    rosbag::BagWriter bag(folder / "a.bag");
    const auto id = bag.add_connection("/imu", std::string(rosbag::kImu.name), std::string(rosbag::kImu.md5), "");
    std::vector<std::uint8_t> bytes;
    TimeNs recorded = kStart;
    for (const int ms : {0, 10, 20, 15, 30, 30, 530, 540}) {
      rosbag::encode_imu({0, kStart + ms * 1'000'000, ""}, Vec3::Zero(), Vec3(0, 0, 9.8), bytes);
      bag.write(id, recorded += 10'000'000, bytes);
    }
    bag.close();
  }
  const InputReport report = inspect(folder / "a.bag");
  REQUIRE(report.topics.size() == 1);
  CHECK((report.topics[0].backward == 1 && report.topics[0].repeated == 1));
  CHECK(report.topics[0].largest_gap == Approx(0.5));
  CHECK_FALSE(report.usable);
}

TEST_CASE("inspection counts empty and malformed messages") {
  const TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int k, TimeNs stamp) {
    return k == 5 ? claims_more(stamp) : livox_message(stamp, stamp, k == 3 || k == 4 ? 0 : 20);
  };
  recording.write(folder / "a.bag");
  const InputReport report = inspect(folder / "a.bag");
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[1].empty == 2);
  CHECK(report.topics[1].malformed == 1);
  CHECK(contains(render(report), "  2 messages without a point that is kept\n"));
  CHECK(contains(render(report), "  1 malformed messages\n"));
  CHECK(report.usable);
}

}  // namespace aslio::io::test
