// Kinds of input that made other programs of this field wrong: each is read as it is meant, or refused with its cause.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "io/clouds.hpp"

namespace aslio::io::test {
namespace {

/// The layout of a Velodyne driver, times from 0 to 98 ms in seconds.
Cloud usual() {
  return with_f32_time([](int i) { return static_cast<float>(1e-9 * static_cast<double>(offset_of(i))); });
}

std::unique_ptr<MeasurementSource> opened(const TemporaryFolder& folder, const Recording& recording,
                                          const SensorConfig& sensor = {}) {
  recording.write(folder / "a.bag");
  return open_source(folder / "a.bag", sensor);
}

TimeNs first_imu(MeasurementSource& source) {
  while (auto measurement = source.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*measurement)) return sample->t;
  }
  return 0;
}

std::vector<ImuSample> all_imu(MeasurementSource& source) {
  std::vector<ImuSample> all;
  while (auto measurement = source.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*measurement)) all.push_back(*sample);
  }
  return all;
}

}  // namespace

TEST_CASE("fields of 64-bit integers and truth values are read, others are stepped over") {
  TemporaryFolder folder;
  const auto cloud = [](TimeNs stamp, std::uint8_t extra) {
    Cloud c;
    c.size(33);
    c.field("valid", 12, kBool);
    c.field("timestamp", 24, kU64);
    c.field("later", 32, extra);
    for (int i = 0; i < kPoints; ++i) c.put(i, 24, static_cast<std::uint64_t>(stamp + offset_of(i) + 1));
    return c;
  };
  for (const std::uint8_t extra : {kBool, std::uint8_t{77}}) {
    const auto source = opened(folder, recording_of([&](TimeNs stamp) { return cloud(stamp, extra); }));
    CHECK(contains(source->notes().verdicts, "field 'timestamp' (uint64), ns, absolute"));
    const LidarPacket packet = first_packet(*source);
    REQUIRE(packet.points.size() == kPoints);
    CHECK(packet.points[7].t == kStart + offset_of(7) + 1);  // to the nanosecond, which a double does not hold
  }
}

TEST_CASE("a wrong row step of dense rows is no harm, and is said once") {
  TemporaryFolder folder;
  for (const std::uint32_t row_step : {0U, 22U * kPoints, 100U}) {
    const auto source = opened(folder, recording_of([&](TimeNs) {
                                 Cloud c = usual();
                                 c.layout.height = 5;
                                 c.layout.width = kPoints / 5;
                                 c.layout.row_step = row_step;
                                 return c;
                               }));
    CHECK(std::count_if(source->notes().warnings.begin(), source->notes().warnings.end(), [](const std::string& text) {
            return contains(text, "`row_step` of the clouds is wrong");
          }) == 1);
    const LidarPacket packet = first_packet(*source);
    REQUIRE(packet.points.size() == kPoints);
    CHECK(packet.points[49].x == 52.0F);
  }
}

TEST_CASE("the byte order of a cloud is that of its values, whatever the flag says") {
  TemporaryFolder folder;
  for (const bool truly : {false, true}) {
    const auto source = opened(folder, recording_of([&](TimeNs) {
                                 Cloud c = usual();
                                 c.layout.is_bigendian = true;
                                 for (int i = 0; i < kPoints && truly; ++i) {
                                   std::uint8_t* point =
                                       c.data.data() + static_cast<std::size_t>(i) * c.layout.point_step;
                                   for (const int at : {0, 4, 8, 12, 18}) std::reverse(point + at, point + at + 4);
                                   std::reverse(point + 16, point + 18);
                                 }
                                 return c;
                               }));
    CHECK(contains(source->notes().warnings, truly ? "they are big-endian" : "they are little-endian"));
    const LidarPacket packet = first_packet(*source);
    REQUIRE(packet.points.size() == kPoints);
    CHECK(packet.points[3].x == 6.0F);
    CHECK(packet.points[3].t == kStart + 6'000'000);
  }
}

TEST_CASE("a time field of another name is suggested, and taken when it is named") {
  TemporaryFolder folder;
  const Recording recording = recording_of([](TimeNs) {
    Cloud c;
    c.size(20);
    c.field("time_offset_ns", 16, kI32);
    for (int i = 0; i < kPoints; ++i) c.put(i, 16, static_cast<std::int32_t>(offset_of(i)));
    return c;
  });
  CHECK(contains(refusal(recording), "set `point_time_field: time_offset_ns`"));
  SensorConfig sensor;
  sensor.times.point_time_field = "time_offset_ns";
  CHECK(first_packet(*opened(folder, recording, sensor)).points[9].t == kStart + offset_of(9));
  sensor.times.point_time_field = "clock";
  CHECK(contains(refusal(recording, sensor), "there is no field 'clock' (`point_time_field`)"));
}

TEST_CASE("the ring may have another name") {
  TemporaryFolder folder;
  for (const char* name : {"channel", "laser_id"}) {
    const auto source = opened(folder, recording_of([&](TimeNs) {
                                 Cloud c = usual();
                                 c.layout.fields[4].name = name;
                                 for (int i = 0; i < kPoints; ++i) c.put(i, 16, static_cast<std::uint16_t>(i % 16));
                                 return c;
                               }));
    CHECK(first_packet(*source).points[17].line == 1);
  }
}

TEST_CASE("a sweep of a narrow view is read, with a word on its span") {
  TemporaryFolder folder;
  const auto source = opened(folder, recording_of([](TimeNs) {
                               return with_f32_time([](int i) { return 0.00016F * static_cast<float>(i); });
                             }));
  CHECK(contains(source->notes().warnings, "of a sweep of 0.1 s: is the view limited?"));
  CHECK(first_packet(*source).points[49].t - kStart == Approx(7'840'000).margin(10));
}

TEST_CASE("what the header stamp and the point times are of can be declared") {
  TemporaryFolder folder;
  const Recording recording = recording_of([](TimeNs) { return usual(); });
  const auto first_time = [&](LidarStamp stamp, PointTime time) {
    SensorConfig sensor;
    sensor.times.lidar_stamp = stamp;
    sensor.times.point_time = time;
    return first_packet(*opened(folder, recording, sensor)).points[0].t - kStart;
  };
  CHECK(first_time(LidarStamp::automatic, PointTime::automatic) == 0);
  CHECK(first_time(LidarStamp::start, PointTime::start) == 0);
  CHECK(first_time(LidarStamp::end, PointTime::automatic) == -kSecond / 10);
  CHECK(first_time(LidarStamp::middle, PointTime::start) == -kSecond / 20);
  CHECK(first_time(LidarStamp::start, PointTime::end) == kSecond / 10);
  SensorConfig untimed;
  untimed.times.deskewed = true;
  const auto source = opened(folder, recording, untimed);
  CHECK(contains(source->notes().verdicts, "all points of a sweep are of the header stamp (deskewed)"));
  const LidarPacket packet = first_packet(*source);
  CHECK(packet.points.back().t == packet.stamp);
}

TEST_CASE("sweeps that end after their messages were recorded are named, with the key that mends it") {
  TemporaryFolder folder;
  const auto warned = [&](const Recording& recording, LidarStamp stamp) {
    SensorConfig sensor;
    sensor.times.lidar_stamp = stamp;
    const auto source = opened(folder, recording, sensor);
    drain(*source);
    return contains(source->notes().warnings, "sweeps end 0.094 s after their messages were recorded") &&
           contains(source->notes().warnings, "`lidar_stamp: end`");
  };
  // The stamp is of the end of the sweep, 4 ms before the message is recorded.
  Recording at_end = recording_of([](TimeNs) { return usual(); });
  at_end.recorded = [](TimeNs stamp) { return stamp + 5'000'000; };
  at_end.imu_stamp = [](int, TimeNs stamp) { return stamp + 4'000'000; };
  CHECK(warned(at_end, LidarStamp::automatic));
  CHECK_FALSE(warned(at_end, LidarStamp::end));
  // Of its begin: the message comes a sweep later.
  Recording at_begin = at_end;
  at_begin.recorded = [](TimeNs stamp) { return stamp + 105'000'000; };
  at_begin.imu_stamp = [](int, TimeNs stamp) { return stamp + 104'000'000; };
  CHECK_FALSE(warned(at_begin, LidarStamp::automatic));
  // A conversion took the stamps for the times of recording.
  Recording converted = recording_of([](TimeNs) { return usual(); });
  CHECK_FALSE(warned(converted, LidarStamp::automatic));
}

TEST_CASE("a header of another clock is no harm where point times are of the IMU's") {
  TemporaryFolder folder;
  const Recording recording = recording_of([](TimeNs stamp) {
    Cloud c;
    c.size(26);
    c.field("timestamp", 18, kF64);
    for (int i = 0; i < kPoints; ++i) c.put(i, 18, 1e-9 * static_cast<double>(stamp + offset_of(i)));
    return c;
  });
  Recording zero = recording;
  zero.lidar = [&](int k, TimeNs stamp) {
    std::vector<std::uint8_t> bytes = recording.lidar(k, stamp);
    std::fill(bytes.begin() + 4, bytes.begin() + 12, std::uint8_t{0});  // the stamp
    return bytes;
  };
  const auto source = opened(folder, zero);
  const InputReport report = inspect(folder / "a.bag");
  CHECK(report.usable);
  CHECK(
      std::all_of(report.topics.begin(), report.topics.end(), [](const TopicReport& t) { return t.problem.empty(); }));
  CHECK(contains(source->notes().verdicts, "absolute, the header stamp is of another clock and is not used"));
  CHECK(*source->begin_time() == kStart);
  const LidarPacket packet = first_packet(*source);
  CHECK(std::abs(packet.stamp - kStart) < 500);
  CHECK(std::abs(packet.points[5].t - kStart - offset_of(5)) < 500);
}

TEST_CASE("clocks a constant apart are put right by an offset of any size") {
  TemporaryFolder folder;
  for (const double apart : {37.0, -28'800.0, 1.1}) {
    Recording recording;
    recording.imu_stamp = [apart](int, TimeNs stamp) { return stamp + to_ns(apart); };
    recording.write(folder / "a.bag");
    const std::string text = data_error([&] { open_source(folder / "a.bag", {}); });
    CHECK(contains(text, fmt::format("`imu_time_offset: {:.3f}`", -apart)));
    SensorConfig sensor;
    sensor.times.imu_time_offset = -apart;
    const auto source = open_source(folder / "a.bag", sensor);
    CHECK(first_imu(*source) == kStart);
    SensorConfig lidar;
    lidar.times.lidar_time_offset = apart;
    const auto moved = open_source(folder / "a.bag", lidar);
    CHECK(first_packet(*moved).stamp == kStart + to_ns(apart));
    SensorConfig received;
    received.times.stamps = StampKind::received;
    const auto as_recorded = open_source(folder / "a.bag", received);
    CHECK(first_imu(*as_recorded) == kStart);
  }
  SECTION("less than a second apart is a warning") {
    Recording recording;
    recording.imu_stamp = [](int, TimeNs stamp) { return stamp + 8 * kSecond / 10; };
    CHECK(contains(opened(folder, recording)->notes().warnings, "are 0.800 s apart"));
  }
}

TEST_CASE("the IMU samples of a packet with one stamp are spread over it") {
  TemporaryFolder folder;
  Recording recording;
  recording.turn = [](int i) { return Vec3(0.001 * i, 0, 0); };
  recording.imu_stamp = [](int i, TimeNs) { return kStart + (i / 4 * 4 + 3) * kSecond / 100; };
  const auto source = opened(folder, recording);
  CHECK(contains(source->notes().verdicts, "imu stamps: 4.0 samples share one, that of a packet"));
  const std::vector<ImuSample> samples = all_imu(*source);
  REQUIRE(samples.size() == 200);
  for (int i = 0; i < 200; ++i) {
    CHECK(samples[static_cast<std::size_t>(i)].t == kStart + i * kSecond / 100);
    CHECK(samples[static_cast<std::size_t>(i)].gyro.x() == 0.001 * i);
  }
}

TEST_CASE("IMU stamps that tell no time are named, with the key that takes the times of recording") {
  TemporaryFolder folder;
  Recording recording;
  recording.turn = [](int i) { return Vec3(0.001 * i, 0, 0); };
  recording.imu_stamp = [](int, TimeNs) { return TimeNs{0}; };
  recording.write(folder / "a.bag");
  const std::string zero = data_error([&] { open_source(folder / "a.bag", {}); });
  CHECK(contains(zero, "samples all have the stamp 0 ns"));
  CHECK(contains(zero, "set `stamps: received`"));
  const InputReport report = inspect(folder / "a.bag");
  CHECK_FALSE(report.usable);
  CHECK(contains(report.topics[0].problem, "samples all have the stamp 0 ns"));
  SensorConfig received;
  received.times.stamps = StampKind::received;
  CHECK(all_imu(*open_source(folder / "a.bag", received)).size() == 200);
  recording.imu_stamp = [](int, TimeNs stamp) { return stamp / kSecond * kSecond; };
  recording.write(folder / "b.bag");
  CHECK(contains(data_error([&] { open_source(folder / "b.bag", {}); }), "all of whole seconds"));
}

TEST_CASE("two sensors on one topic are refused, and one of them can be chosen") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int k, TimeNs stamp) {
    std::vector<std::uint8_t> bytes = livox_message(stamp, stamp, 20);
    bytes[4 + 8 + 4 + std::string("livox_frame").size() + 8 + 4] = static_cast<std::uint8_t>(k % 2);  // lidar_id
    return bytes;
  };
  recording.write(folder / "a.bag");
  CHECK(contains(data_error([&] { open_source(folder / "a.bag", {}); }), "2 sensors (lidar_id 0, 1): set `lidar_id`"));
  SensorConfig one;
  one.lidar_id = 1;
  const auto source = open_source(folder / "a.bag", one);
  CHECK(first_packet(*source).stamp == kStart + kSecond / 10);
  CHECK(drain(*open_source(folder / "a.bag", one)).packets == 10);
  CHECK(inspect(folder / "a.bag", one).topics[1].points_per_message ==
        10);  // of 20, half of the messages are not its own

  int number = 0;
  const Recording clouds = recording_of([&](TimeNs) { return usual(); });
  Recording frames = clouds;
  frames.lidar = [&](int k, TimeNs stamp) {
    std::vector<std::uint8_t> bytes = clouds.lidar(k, stamp);
    if (number++ % 2 == 1) bytes[16] = 'L';  // of the frame "lidar"
    return bytes;
  };
  CHECK(contains(refusal(frames), "clouds of 2 frames ('Lidar', 'lidar')"));
  SensorConfig front;
  front.lidar_frame = "lidar";
  number = 0;
  CHECK(drain(*opened(folder, frames, front)).packets == 3);
}

TEST_CASE("offsets in a wrong scale are told by the time between messages") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar = [](int, TimeNs stamp) {
    std::vector<std::uint8_t> bytes = livox_message(stamp, stamp, 400);
    const std::size_t first = bytes.size() - 400U * 19U;
    for (std::size_t i = 0; i < 400; ++i) {
      const auto offset = static_cast<std::uint32_t>(i * 12'474'000 / 400);
      std::memcpy(bytes.data() + first + 19 * i, &offset, 4);
    }
    return bytes;
  };
  CHECK(contains(opened(folder, recording)->notes().warnings, "is it in another scale than ns?"));
}

TEST_CASE("the signs of the axes of an IMU can be turned round") {
  TemporaryFolder folder;
  Recording recording;
  recording.acc = {0, 0, -9.8};
  recording.gyro = {0.01, 0.02, 0.03};
  SensorConfig sensor;
  sensor.acc_signs = {-1, -1, -1};
  sensor.gyro_signs = {1, -1, -1};
  const std::vector<ImuSample> samples = all_imu(*opened(folder, recording, sensor));
  REQUIRE_FALSE(samples.empty());
  CHECK(samples[0].acc.z() == 9.8);
  CHECK(samples[0].gyro == Vec3(0.01, -0.02, -0.03));
}

TEST_CASE("large chunks are read, beside topics that nobody asked for") {
  TemporaryFolder folder;
  const auto write = [&](rosbag::WriterOptions options, std::size_t bytes) {
    rosbag::BagWriter bag(folder / "a.bag", options);
    const auto add = [&](const std::string& topic, const rosbag::MessageType& type) {
      return bag.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
    };
    const std::uint32_t imu = add("/imu", rosbag::kImu), lidar = add("/lidar", rosbag::kLivoxCustomMsg);
    const std::uint32_t blob =
        bag.add_connection("/blob", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data");
    std::vector<std::uint8_t> message;
    for (int i = 0; i < 30; ++i) {
      const TimeNs stamp = kStart + i * kSecond / 100;
      rosbag::encode_imu({0, stamp, ""}, Vec3(0.01, 0, 0), Vec3(0, 0, 9.8), message);
      bag.write(imu, stamp, message);
      if (i % 10 == 0) bag.write(lidar, stamp, livox_message(stamp, stamp, 20));
    }
    std::vector<std::uint8_t> large(bytes);
    std::uint32_t state = 1;
    for (std::uint8_t& byte : large) byte = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
    bag.write(blob, kStart + kSecond, large);
    bag.close();
  };
  SECTION("of lz4, 66 MiB") { write({rosbag::Compression::lz4, 400U << 20U, true}, 66U << 20U); }
  SECTION("uncompressed, 257 MiB") { write({rosbag::Compression::none, 400U << 20U, true}, 257U << 20U); }
  CHECK(inspect(folder / "a.bag").usable);
  CHECK(drain(*open_source(folder / "a.bag", {})).packets == 3);
}

TEST_CASE("inspection drafts the sensor file that fits") {
  TemporaryFolder folder;
  Recording recording;
  recording.acc = {0, 0, 1};
  recording.write(folder / "a.bag");
  const std::string draft = draft_sensor(inspect(folder / "a.bag"));
  for (const char* line : {"lidar_topic: '/livox/lidar'", "imu_topic: '/livox/imu'", "acc_unit: g", "gyro_unit: rad_s",
                           "sweep_period: 0.100", "scan_lines: 6", "T_imu_lidar:"}) {
    CHECK(contains(draft, line));
  }
  recording.imu_type = rosbag::kPointCloud2;  // none is left
  recording.write(folder / "b.bag");
  CHECK(contains(data_error([&] { draft_sensor(inspect(folder / "b.bag")); }), "it has no IMU topic that can be used"));
}

TEST_CASE("a bag that was written topic after topic is refused") {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 30;
  recording.write(folder / "a.bag");
  for (const bool imu_first : {true, false}) {
    rosbag::BagReader reader(folder / "a.bag");
    std::vector<Connection> connections = reader.connections();
    if (!imu_first) std::reverse(connections.begin(), connections.end());
    rosbag::BagWriter writer(folder / "b.bag");
    TimeNs written = kStart;
    for (const Connection& c : connections) {
      const std::uint32_t id = writer.add(c);
      reader.select({&c.id, 1});
      for (rosbag::BagMessage message; reader.next(message);)
        writer.write(id, written += kSecond / 1000, message.bytes);
    }
    writer.close();
    const std::string text = data_error([&] { open_source(folder / "b.bag", {}); });
    CHECK(contains(text, "the topics were written one after the other"));
    CHECK(contains(text, imu_first ? "the messages of '/livox/lidar' come" : "the messages of '/livox/imu' come"));
  }
}

TEST_CASE("a key that a kind of message does not read is refused") {
  TemporaryFolder folder;
  Recording().write(folder / "livox.bag");
  recording_of([](TimeNs) { return usual(); }).write(folder / "cloud.bag");
  const auto refused = [&](const char* bag, const std::function<void(SensorConfig&)>& set) {
    SensorConfig sensor;
    set(sensor);
    return data_error([&] { open_source(folder / bag, sensor); });
  };
  CHECK(contains(refused("livox.bag", [](SensorConfig& s) { s.times.point_time_field = "t"; }), "`point_time_field`"));
  CHECK(contains(refused("livox.bag", [](SensorConfig& s) { s.times.point_time = PointTime::end; }), "`point_time`"));
  CHECK(contains(refused("livox.bag", [](SensorConfig& s) { s.lidar_frame = "front"; }), "`lidar_frame`"));
  CHECK(contains(refused("cloud.bag", [](SensorConfig& s) { s.lidar_id = 1; }), "no meaning for PointCloud2"));
  CHECK(refused("livox.bag", [](SensorConfig& s) { s.times.deskewed = true; }).empty());
}

}  // namespace aslio::io::test
