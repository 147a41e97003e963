// Packets of Velodyne, Hesai and Ouster, each encoded here.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "../../framework/io/src/io/packets/hesai.hpp"
#include "../../framework/io/src/io/packets/ouster.hpp"
#include "../../framework/io/src/io/packets/sweep_decoder.hpp"
#include "../../framework/io/src/io/packets/sweep_message.hpp"
#include "../../framework/io/src/io/packets/velodyne.hpp"
#include "io/bag_fixture.hpp"
#include "io/packet_fixture.hpp"

namespace aslio::io::packets {
namespace {

using namespace io::test;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kAllLines = 256;

LidarPacket decoded(const PacketFormat& format, const PacketBytes& packet, TimeNs begin = kStart) {
  LidarPacket out;
  REQUIRE(format.decode(packet, begin, kAllLines, out).empty());
  return out;
}

/// Whatever is cut off a packet: the rest is refused, or decoded, and never read beyond its end.
void survives_cuts(const PacketFormat& format, const PacketBytes& packet) {
  for (std::size_t size = 0; size < packet.size(); ++size) {
    // A copy of its own, so that a sanitizer sees what lies behind.
    const PacketBytes cut(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size));
    LidarPacket out;
    PacketHead head;
    CHECK(!format.head(cut, head).empty());
    CHECK(!format.decode(cut, 0, kAllLines, out).empty());
    CHECK(out.points.empty());
  }
}

double norm(const TimedPoint& p) { return std::sqrt(double{p.x} * p.x + double{p.y} * p.y + double{p.z} * p.z); }

}  // namespace

TEST_CASE("a VLP-16 fires twice in a block, each laser at its time and angle") {
  const auto format = make_velodyne(VelodyneModel::vlp16, false);
  VelodynePacket packet;
  packet.first = 9000 - 40;
  const LidarPacket out = decoded(*format, packet.bytes());
  REQUIRE(out.points.size() == 12 * 32);
  // Laser 3 of the second firing of block 1, which is at 90 deg: 55.296 + 3 * 2.304 us later, of 110.592 per 0.4 deg.
  const TimedPoint& p = out.points[32 + 16 + 3];
  const double since = 55296 + 3 * 2304, azimuth = (90 + 0.4 * since / 110592) * kDegree, elevation = 3 * kDegree;
  CHECK(p.t == kStart + 110592 + std::llround(since));
  CHECK(p.x == Approx(10 * std::cos(elevation) * std::cos(azimuth)).margin(1e-5));
  CHECK(p.y == Approx(-10 * std::cos(elevation) * std::sin(azimuth)).margin(1e-5));
  CHECK(p.z == Approx(10 * std::sin(elevation) - 0.0022).margin(1e-5));
  CHECK(p.line == 9);
  CHECK(p.intensity == 19);
  CHECK(out.points.front().line == 0);
  PacketHead head;
  packet.microseconds = 3'599'999'000;
  REQUIRE(format->head(packet.bytes(), head).empty());
  CHECK(head.turn == Approx(89.6 / 360));
  CHECK(head.time == 3'599'999 * kSecond / 1000);
  survives_cuts(*format, packet.bytes());
}

TEST_CASE("of two returns of a Velodyne the strongest is kept") {
  const auto format = make_velodyne(VelodyneModel::vlp16, true);
  VelodynePacket packet;
  packet.mode = 0x39;
  packet.distance = [](std::size_t block, std::size_t) {
    return static_cast<std::uint16_t>(block % 2 == 0 ? 4000 : 2500);
  };
  const LidarPacket out = decoded(*format, packet.bytes());
  REQUIRE(out.points.size() == 6 * 32);
  CHECK(norm(out.points[7]) == Approx(5).margin(0.012));
  CHECK(out.points[32].t == kStart + 110592);
  CHECK(contains(format->verdict(), "strongest one is kept"));
}

TEST_CASE("returns of no distance and blocks of another kind are dropped and counted") {
  const auto format = make_velodyne(VelodyneModel::hdl32e, false);
  VelodynePacket packet;
  packet.distance = [](std::size_t, std::size_t i) { return static_cast<std::uint16_t>(i == 5 ? 0 : 5000); };
  packet.flag = [](std::size_t block) { return static_cast<std::uint16_t>(block == 3 ? 0x1234 : 0xEEFF); };
  const LidarPacket out = decoded(*format, packet.bytes());
  CHECK(out.points.size() == 11 * 31);
  CHECK(out.dropped_invalid == 11 + 32);
  LidarPacket few;
  REQUIRE(format->decode(packet.bytes(), 0, 16, few).empty());
  CHECK(few.points.size() + few.beyond_lines == 11 * 31);
  CHECK(few.highest_line == 31);
}

TEST_CASE("lasers of a VLP-32C stand aside, those of a VLS-128 come in banks") {
  VelodynePacket packet;
  const auto vlp32 = make_velodyne(VelodyneModel::vlp32c, false);
  const LidarPacket a = decoded(*vlp32, packet.bytes());
  REQUIRE(a.points.size() == 12 * 32);
  // Laser 1: -1 deg up, -4.2 deg aside; it fires with laser 0.
  CHECK(a.points[1].y == Approx(20 * std::cos(kDegree) * std::sin(4.2 * kDegree)).margin(1e-4));
  CHECK(a.points[1].t == kStart);
  CHECK(a.points[2].t == kStart + 2304);
  const auto vls = make_velodyne(VelodyneModel::vls128, false);
  packet.product = 0xA1;
  packet.flag = [](std::size_t block) { return static_cast<std::uint16_t>(0xEEFF - 0x1100 * (block % 4)); };
  const LidarPacket b = decoded(*vls, packet.bytes());
  REQUIRE(b.points.size() == 12 * 32);
  // Laser 64 is of the ninth group, after the pause; laser 36 is the lowest.
  CHECK(b.points[64].t - b.points[0].t == 9 * 2665);
  CHECK(b.points[128].t - b.points[0].t == 53300);
  CHECK(b.points[36].line == 0);
  CHECK(b.points[36].z == Approx(-20 * std::sin(25 * kDegree)).margin(1e-4));
  survives_cuts(*vls, packet.bytes());
}

TEST_CASE("the model of a Velodyne is told by its packets") {
  const auto verdict = [](std::uint8_t product, std::uint32_t period) {
    std::vector<PacketBytes> all;
    std::vector<Packet> packets;
    for (std::uint32_t i = 0; i < 5; ++i) {
      VelodynePacket packet;
      packet.product = product;
      packet.microseconds = i * period;
      all.push_back(packet.bytes());
    }
    for (const PacketBytes& bytes : all) packets.push_back({kStart, bytes});
    std::string why;
    const auto format = make_velodyne(packets, why);
    return format ? format->verdict() : why;
  };
  CHECK(contains(verdict(0x22, 1327), "VLP-16"));
  CHECK(contains(verdict(0x24, 1327), "Puck Hi-Res"));
  CHECK(contains(verdict(0x21, 553), "HDL-32E"));
  CHECK(contains(verdict(0x21, 1327), "VLP-16"));
  CHECK(contains(verdict(0x28, 664), "VLP-32C"));
  CHECK(contains(verdict(0xA1, 160), "VLS-128"));
  CHECK(contains(verdict(0x77, 553), "product 0x77 of Velodyne is not known"));
}

TEST_CASE("a position packet of an HDL-32E holds its inertial sensors") {
  PacketBytes packet(512, 0);
  put_number(packet, 14, 0x1FFF, 2);             // gyro 1: -1
  put_number(packet, 14 + 8, 100, 2);            // gyro 2
  put_number(packet, 14 + 16, 0x2000 - 300, 2);  // gyro 3; the highest 4 bits mean nothing
  put_number(packet, 14 + 4, 800, 2);            // accelerometer 1 x
  put_number(packet, 14 + 12, 820, 2);           // accelerometer 2 x
  put_number(packet, 198, 5'000'001, 4);
  const std::string sentence = "$GPRMC,220243,A";
  std::copy(sentence.begin(), sentence.end(), packet.begin() + 206);
  VelodynePosition position;
  REQUIRE(decode_velodyne_position(packet, position).empty());
  const double unit = 0.09766 * kDegree;
  CHECK((position.gyro - unit * Vec3(100, 1, -300)).norm() < 1e-12);
  CHECK((position.acc - Vec3(0, 0, 810 * 0.001221 * kStandardGravity)).norm() < 1e-12);
  CHECK(position.time == 5'000'001'000);
  CHECK(position.has_imu);
  CHECK(position.nmea == sentence);
  packet.resize(511);
  CHECK(!decode_velodyne_position(packet, position).empty());
}

TEST_CASE("packets of every Hesai are told apart and decoded") {
  struct Case {
    PacketBytes packet;
    std::string name;
    std::size_t points, channel;
    double elevation, azimuth;
    TimeNs at;  ///< of that channel in the second block, from the first firing of the packet
  };
  HesaiPacket xt16, xt32, qt64;
  xt16.channels = 16;
  qt64.channels = 64;
  const std::vector<Case> cases{{xt16.bytes(), "XT16", 8 * 16, 2, 11, 0.18, 50000 + 368 + 2 * 3024},
                                {xt32.bytes(), "XT32", 8 * 32, 2, 13, 0.18, 50000 + 368 + 2 * 1512},
                                {qt64.bytes(), "QT64", 4 * 64, 32, 0.725, 5.493 + 0.18, 166667 + 80900},
                                {pandar40p_packet(0, 2500), "Pandar40P", 400, 39, -24.985, -1.042 + 0.2, 55560 - 3620}};
  for (const Case& one : cases) {
    INFO(one.name);
    std::string why;
    const std::vector<Packet> first{{kStart, one.packet}};
    const auto format = make_hesai(first, {}, why);
    REQUIRE(format);
    CHECK(contains(format->verdict(), one.name));
    const LidarPacket out = decoded(*format, one.packet);
    REQUIRE(out.points.size() == one.points);
    const TimedPoint& p = out.points[hesai_channels(*hesai_model(one.packet)) + one.channel];
    CHECK(p.line == one.channel);
    CHECK(std::abs(p.t - kStart - one.at) <= 1);
    CHECK(p.z == Approx(10 * std::sin(one.elevation * kDegree)).margin(1e-5));
    CHECK(p.x == Approx(10 * std::cos(one.elevation * kDegree) * std::sin(one.azimuth * kDegree)).margin(1e-5));
    CHECK(p.y == Approx(10 * std::cos(one.elevation * kDegree) * std::cos(one.azimuth * kDegree)).margin(1e-5));
    survives_cuts(*format, one.packet);
    PacketHead head;
    REQUIRE(format->head(one.packet, head).empty());
    CHECK(std::abs(head.time - kStart) < kSecond / 1000);
  }
}

TEST_CASE("of two returns of a Hesai the last one is kept, and packets that are missing are counted") {
  HesaiPacket packet;
  packet.mode = 0x39;
  packet.distance = [](std::size_t block, std::size_t) {
    return static_cast<std::uint16_t>(block % 2 == 0 ? 2500 : 1000);
  };
  std::vector<PacketBytes> all;
  for (const std::uint32_t sequence : {7U, 8U, 11U}) {
    packet.sequence = sequence;
    packet.microseconds = 200 * sequence;
    packet.first = 72 * sequence;
    all.push_back(packet.bytes());
  }
  std::vector<Packet> packets;
  for (const PacketBytes& bytes : all) packets.push_back({kStart + kSecond, bytes});
  std::string why;
  const auto format = make_hesai(packets, {}, why);
  REQUIRE(format);
  CHECK(contains(format->verdict(), "the last one is kept"));
  LidarPacket out;
  const Sweep sweep = decode_packets(*format, packets, kAllLines, out);
  CHECK(sweep.missing == 2);
  REQUIRE(out.points.size() == 3 * 4 * 32);
  CHECK(norm(out.points.front()) == Approx(10).margin(1e-4));
  CHECK(out.points[2 * 4 * 32].t - out.points[0].t == 4 * 200'000);
}

TEST_CASE("a table of a Hesai's own angles is read, and refused where it is none") {
  const HesaiBeams beams = read_hesai_beams("a.csv", "Channel,Elevation,Azimuth\r\n1,14.97,0.08\r\n2, 13.95 ,-1\r\n");
  REQUIRE(beams.size() == 2);
  CHECK(beams[1].elevation == 13.95);
  CHECK(beams[1].azimuth == -1);
  const auto refusal = [](const std::string& text) { return data_error([&] { read_hesai_beams("a.csv", text); }); };
  CHECK(contains(refusal(""), "a.csv: it holds no line"));
  CHECK(contains(refusal("1,2,3\n3,2,1\n"), "a.csv, line 2: '3,2,1'"));
  CHECK(contains(refusal("1,2,3\n2,nan,1\n"), "a.csv, line 2"));
  CHECK(contains(refusal("1,95,3\n"), "a.csv, line 1"));
  HesaiPacket packet;
  const PacketBytes bytes = packet.bytes();
  const std::vector<Packet> first{{kStart, bytes}};
  std::string why;
  CHECK(contains(data_error([&] { make_hesai(first, beams, why); }), "has 2 channels, a XT32 has 32"));
}

TEST_CASE("columns of an Ouster stand where the manual puts them") {
  for (const bool legacy : {true, false}) {
    const OusterMetadata metadata =
        parse_ouster_metadata("a.json", ouster_metadata(legacy ? "LEGACY" : "RNG19_RFL8_SIG16_NIR16"));
    const auto format = make_ouster(metadata);
    const PacketBytes packet = ouster_packet(legacy, 3, 128, 5 * kSecond, 4015);
    REQUIRE(packet.size() == metadata.packet_bytes());
    const LidarPacket out = decoded(*format, packet);
    REQUIRE(out.points.size() == 16 * 16);
    // Column 128 of 512: the encoder is at 270 deg; the LiDAR frame is turned by 180 deg in the sensor frame.
    CHECK(out.points[0].x == Approx(0).margin(1e-6));
    CHECK(out.points[0].y == Approx(4.015));
    CHECK(out.points[0].z == Approx(0.036));
    CHECK(out.points[17].line == 1);
    CHECK(out.points[17].t == kStart + 195312);
    CHECK(out.points[17].intensity == 1);
    PacketHead head;
    REQUIRE(format->head(packet, head).empty());
    CHECK(head.frame == 3);
    CHECK(head.time == 5 * kSecond);
    CHECK(contains(format->verdict(), "[-0.006253, 0.011775, -0.007645]"));
    survives_cuts(*format, packet);
  }
}

TEST_CASE("metadata of an Ouster that cannot be used is refused with its reason") {
  const auto refusal = [](const std::string& json) {
    return data_error([&] { parse_ouster_metadata("a.json", json); });
  };
  const std::string good = ouster_metadata("LEGACY");
  const auto changed = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  CHECK(refusal(good).empty());
  CHECK(contains(refusal("{"), "a.json: the metadata is no JSON object"));
  CHECK(contains(refusal("{}"), "there is no array `beam_altitude_angles`"));
  CHECK(contains(refusal(changed("\"LEGACY\"", "\"FUSA\"")), "profile FUSA, where LEGACY, RNG19"));
  CHECK(contains(refusal(changed("512", "1e9")), "`columns_per_frame` is 1000000000.0"));
  CHECK(contains(refusal(changed("\"pixels_per_column\": 16", "\"pixels_per_column\": 64")), "for 64 rows"));
  CHECK(contains(refusal(changed("36, 0", "36")), "has 15 numbers, not 16"));
  CHECK(contains(refusal(changed("[-1, 0", "[-2, 0")), "holds no rotation"));
}

TEST_CASE("an IMU packet of an Ouster is in SI") {
  OusterImu imu;
  REQUIRE(decode_ouster_imu(ouster_imu(kSecond, 1.0F, 90.0F), imu).empty());
  CHECK(imu.acc.z() == kStandardGravity);
  CHECK(imu.gyro.z() == Approx(std::numbers::pi / 2));
  CHECK(imu.time == kSecond);
  CHECK(!decode_ouster_imu(PacketBytes(47), imu).empty());
}

TEST_CASE("a bag of Velodyne's packets is read like one of clouds") {
  // 10 sweeps of 75 packets, which the computer receives late by up to 3 ms.
  const auto scan = [](int k, bool cdr) {
    std::vector<std::pair<TimeNs, PacketBytes>> packets;
    for (int i = 0; i < 75; ++i) {
      if (k == 2 && i == 30) continue;
      VelodynePacket packet;
      const TimeNs since = k * kSecond / 10 + i * 1'327'104LL;
      packet.first = i * 480;
      packet.microseconds = static_cast<std::uint32_t>((3'599'900'000 + since / 1000) % 3'600'000'000);
      packets.emplace_back(kStart + since + (i % 5 == 0 ? 0 : 3'000'000), packet.bytes());
    }
    return velodyne_scan(packets.back().first, packets, cdr);
  };
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 1;
  recording.lidar_type = {"velodyne_msgs/VelodyneScan", "50804fc9533a0e579e6322c04ae70566", ""};
  recording.lidar = [&](int k, TimeNs) { return scan(k, false); };
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.model.scan_lines = 16;
  const auto source = open_source(folder / "a.bag", sensor);
  CHECK(contains(source->notes().verdicts, "lidar packets: Velodyne VLP-16, one return"));
  std::vector<LidarPacket> sweeps;
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) sweeps.push_back(*packet);
  }
  REQUIRE(sweeps.size() == 10);
  CHECK(sweeps[0].points.size() == 75 * 384);
  CHECK(sweeps[2].points.size() == 74 * 384);
  // The hour ends within the second sweep; the delays are not in the times.
  for (std::size_t k = 0; k < 10; ++k) {
    CHECK(std::abs(sweeps[k].points.front().t - (kStart + static_cast<TimeNs>(k) * kSecond / 10)) < 2000);
    CHECK(std::abs(sweeps[k].points[74 * 384 - 1].t - sweeps[k].points[0].t - (k == 2 ? 75 : 74) * 1'327'104LL +
                   110592 - 55296 - 15 * 2304) < 60000);
  }
  CHECK(contains(source->notes().warnings, "1 of 750 packets are missing"));
  SweepMessage message;
  for (const bool cdr : {false, true}) {
    const auto bytes = scan(0, cdr);
    const Encoding encoding = cdr ? Encoding::cdr : Encoding::ros1;
    REQUIRE(parse_sweep({bytes, encoding}, true, message).empty());
    CHECK(message.packets.size() == 75);
    CHECK(!parse_sweep({std::span(bytes).first(bytes.size() - 1), encoding}, true, message).empty());
  }
}

TEST_CASE("a sweep made of datagrams is read back, and a count that the bytes cannot hold is refused") {
  const PacketBytes a(100, 1), b(1500, 2);
  const std::vector<Packet> packets{{kStart, a}, {kStart + 5, b}};
  std::vector<std::uint8_t> bytes;
  encode_sweep(3, kStart, "lidar", packets, bytes);
  SweepMessage message;
  REQUIRE(parse_sweep({bytes, Encoding::ros1}, false, message).empty());
  REQUIRE(message.packets.size() == 2);
  CHECK(message.packets[1].received == kStart + 5);
  CHECK(message.packets[1].bytes.size() == 1500);
  CHECK(message.packets[0].bytes[99] == 1);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    CHECK(!parse_sweep({std::span(bytes).first(size), Encoding::ros1}, false, message).empty());
  }
  put_number(bytes, 4 + 8 + 4 + 5, 0xFFFFFFFF, 4);
  CHECK(contains(parse_sweep({bytes, Encoding::ros1}, false, message), "claims 4294967295 packets"));
}

}  // namespace aslio::io::packets
