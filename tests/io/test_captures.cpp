// Network captures, each written here.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "../../framework/io/src/io/packets/capture_file.hpp"
#include "../../framework/io/src/io/packets/sensor_clock.hpp"
#include "io/bag_fixture.hpp"
#include "io/packet_fixture.hpp"

namespace aslio::io::test {
namespace {

/// The sensor's clock counts from its start; its packets arrive 2 ms after their first firing.
constexpr TimeNs kSensorStart = 77 * kSecond, kDelay = 2'000'000;

PacketBytes position_packet(TimeNs sensor_time) {
  PacketBytes packet(512, 0);
  put_number(packet, 14 + 16, 205, 2);  // 20 deg/s about z
  put_number(packet, 14 + 4, 819, 2);
  put_number(packet, 14 + 12, 819, 2);
  put_number(packet, 198, static_cast<std::uint64_t>(sensor_time / 1000), 4);
  return packet;
}

/// An HDL-32E with its IMU at 200 Hz.
std::vector<SentDatagram> hdl32e(double seconds, std::array<std::uint8_t, 4> source = {192, 168, 1, 201}) {
  std::vector<SentDatagram> all;
  const auto add = [&](TimeNs since, std::uint16_t port, PacketBytes payload) {
    SentDatagram& sent = all.emplace_back();
    sent.time = kStart + since + kDelay;
    sent.payload = std::move(payload);
    sent.source = source;
    sent.port = port;
  };
  for (int i = 0; i * 552'960LL < to_ns(seconds); ++i) {
    VelodynePacket packet;
    packet.product = 0x21;
    packet.step = 16;
    packet.first = i * 199 % 36000;
    packet.microseconds = static_cast<std::uint32_t>((kSensorStart + i * 552'960LL) / 1000);
    add(i * 552'960LL, 2368, packet.bytes());
  }
  for (int i = 0; i * 5'000'000LL < to_ns(seconds); ++i) {
    add(i * 5'000'000LL, 8308, position_packet(kSensorStart + i * 5'000'000LL));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return all;
}

/// An Ouster, 512x10 with 16 rows, whose packets come in fragments; IMU at 100 Hz.
std::vector<SentDatagram> ouster(double seconds) {
  std::vector<SentDatagram> all;
  constexpr TimeNs kPacket = 16 * 195312;
  const auto add = [&](TimeNs since, std::uint16_t port, PacketBytes payload) {
    SentDatagram& sent = all.emplace_back();
    sent.time = kStart + since + kDelay;
    sent.payload = std::move(payload);
    sent.port = port;
    sent.vlan = true;
    sent.id = static_cast<std::uint16_t>(all.size());
    if (port == 7502) sent.fragment_bytes = 1480;
  };
  for (int i = 0; i * kPacket < to_ns(seconds); ++i) {
    const auto frame = static_cast<std::uint16_t>(65530 + i / 32), column = static_cast<std::uint16_t>(i % 32 * 16);
    add(i * kPacket, 7502, ouster_packet(false, frame, column, kSensorStart + i * kPacket, 5000));
  }
  for (int i = 0; i * 10'000'000LL < to_ns(seconds); ++i) {
    add(i * 10'000'000LL, 7503, ouster_imu(kSensorStart + i * 10'000'000LL, 1.0F, 20.0F));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return all;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  write_bytes(path, {text.begin(), text.end()});
}

struct Read {
  std::vector<LidarPacket> sweeps;
  std::vector<ImuSample> imu;
};
Read read_all(MeasurementSource& source) {
  Read read;
  while (const auto measurement = source.next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      read.sweeps.push_back(*packet);
    } else {
      read.imu.push_back(std::get<ImuSample>(*measurement));
    }
  }
  return read;
}

SensorConfig lines(int count) {
  SensorConfig sensor;
  sensor.model.scan_lines = count;
  return sensor;
}

}  // namespace

TEST_CASE("a capture of an HDL-32E gives sweeps and its own IMU, by one clock") {
  TemporaryFolder folder;
  for (const CaptureForm form : {CaptureForm::pcap, CaptureForm::pcapng}) {
    write_bytes(folder / "a.pcap", capture(hdl32e(1.0), form));
    const auto source = open_source(folder / "a.pcap", lines(32));
    CHECK(contains(source->notes().verdicts, "Velodyne HDL-32E, one return"));
    const Read read = read_all(*source);
    CHECK(source->status() == InputStatus::complete);
    REQUIRE(read.sweeps.size() == 10);
    CHECK(read.sweeps[1].points.size() == 181 * 384);
    CHECK(read.imu.size() == 200);
    CHECK((read.imu[7].acc - Vec3(0, 0, 819 * 0.001221 * kStandardGravity)).norm() < 1e-9);
    CHECK(read.imu[7].gyro.z() == Approx(205 * 0.09766 * std::numbers::pi / 180));
    // Times are those of the sensor's clock, moved by the least delay.
    CHECK(std::abs(read.imu[100].t - (kStart + kDelay + 100 * 5'000'000LL)) < 110'000);
    CHECK(std::abs(read.sweeps[1].points[0].t - (kStart + kDelay + 181 * 552'960LL)) < 110'000);
    const InputReport report = inspect(folder / "a.pcap", lines(32));
    CHECK(report.usable);
    CHECK(report.kind == "network capture");
  }
}

TEST_CASE("a capture of an Ouster in fragments is put together, with the metadata beside it or named") {
  TemporaryFolder folder;
  write_bytes(folder / "a_run1.pcap", capture(ouster(0.49)));
  const auto read_with = [&](const SensorConfig& sensor) {
    const auto source = open_source(folder / "a_run1.pcap", sensor);
    const Read read = read_all(*source);
    REQUIRE(read.sweeps.size() == 5);
    CHECK(read.sweeps[2].points.size() == 512 * 16);
    CHECK(read.imu.size() == 49);
    CHECK(read.imu[3].acc.z() == Approx(kStandardGravity));
    CHECK(std::abs(read.sweeps[2].points[0].t - (kStart + kDelay + 64 * 16 * 195312)) < 100'000);
    CHECK(contains(source->notes().verdicts, "Ouster OS-1-16, 512x16, profile RNG19_RFL8_SIG16_NIR16"));
  };
  const std::string missing = data_error([&] { open_source(folder / "a_run1.pcap", lines(16)); });
  CHECK(contains(missing, "need the metadata"));
  CHECK(contains(missing, "a_run1.json"));
  SensorConfig named = lines(16);
  named.lidar_metadata = (folder / "other.json").string();
  write_text(named.lidar_metadata, ouster_metadata("RNG19_RFL8_SIG16_NIR16"));
  read_with(named);
  write_text(folder / "a.json", ouster_metadata("RNG19_RFL8_SIG16_NIR16"));
  read_with(lines(16));
  write_text(folder / "a_run1.json", ouster_metadata("LEGACY"));
  CHECK(contains(data_error([&] { open_source(folder / "a_run1.pcap", lines(16)); }),
                 "no datagram is of the 3392 bytes"));
}

TEST_CASE("of several sensors in a capture one is chosen by its address") {
  TemporaryFolder folder;
  std::vector<SentDatagram> all = hdl32e(0.5);
  for (SentDatagram& sent : hdl32e(0.5, {192, 168, 1, 202})) all.push_back(sent);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  write_bytes(folder / "a.pcap", capture(all));
  const std::string refusal = data_error([&] { open_source(folder / "a.pcap", lines(32)); });
  CHECK(contains(refusal, "more than one LiDAR; set `lidar_address`"));
  CHECK(contains(refusal, "192.168.1.201:2368"));
  CHECK(contains(refusal, "192.168.1.202:2368"));
  SensorConfig sensor = lines(32);
  for (const std::string address : {"192.168.1.202", "192.168.1.202:2368"}) {
    sensor.lidar_address = address;
    const Read read = read_all(*open_source(folder / "a.pcap", sensor));
    CHECK(read.sweeps.size() == 5);
    CHECK(read.imu.size() == 100);
  }
  sensor.lidar_address = "10.0.0.1";
  CHECK(contains(data_error([&] { open_source(folder / "a.pcap", sensor); }),
                 "no LiDAR sends from `lidar_address` 10.0.0.1"));
}

TEST_CASE("captures that cannot be used are refused with what they hold") {
  TemporaryFolder folder;
  SentDatagram other;
  other.time = kStart;
  other.payload = PacketBytes(100, 1);
  write_bytes(folder / "a.pcap", capture({other}));
  const std::string refusal = data_error([&] { open_source(folder / "a.pcap", {}); });
  CHECK(contains(refusal, "no packets of a LiDAR"));
  CHECK(contains(refusal, "192.168.1.201:2368 (1 datagrams, the last of 100 bytes)"));
  auto bytes = capture({other});
  bytes[20] = 147;  // a link of the user's own
  write_bytes(folder / "b.pcap", bytes);
  CHECK(contains(data_error([&] { open_source(folder / "b.pcap", {}); }), "a link of type 147"));
  write_bytes(folder / "c.pcap", capture({}));
  CHECK(contains(data_error([&] { open_source(folder / "c.pcap", {}); }), "(none)"));
  write_bytes(folder / "d.pcap", {0x4D, 0x3C, 0xB2, 0xA1, 1});
  CHECK(contains(data_error([&] { open_source(folder / "d.pcap", {}); }), "cannot be read as a network capture"));
  // Without an IMU, as all Velodynes but the HDL-32E are.
  std::vector<SentDatagram> lidar = hdl32e(0.3);
  std::erase_if(lidar, [](const SentDatagram& sent) { return sent.port != 2368; });
  write_bytes(folder / "e.pcap", capture(lidar));
  CHECK(contains(data_error([&] { open_source(folder / "e.pcap", lines(32)); }), "there is no IMU topic"));
  CHECK(inspect(folder / "e.pcap", lines(32)).topics.at(0).points_per_message > 10'000);
}

TEST_CASE("a capture that is cut short is read to its last whole packet") {
  TemporaryFolder folder;
  auto bytes = capture(hdl32e(1.0));
  bytes.resize(bytes.size() * 7 / 10);
  write_bytes(folder / "a.pcap", bytes);
  const auto source = open_source(folder / "a.pcap", lines(32));
  const Read read = read_all(*source);
  CHECK(read.sweeps.size() == 7);
  CHECK(source->status() == InputStatus::truncated);
  CHECK(contains(source->notes().warnings, "it ends within a record"));
}

TEST_CASE("datagrams lack fragments, or come twice by one number, and the others are read") {
  TemporaryFolder folder;
  SentDatagram sent;
  sent.payload = PacketBytes(4000, 7);
  sent.fragment_bytes = 1480;
  sent.id = 5;
  const auto count = [&](const std::vector<SentDatagram>& datagrams, std::vector<std::size_t> left_out) {
    std::vector<SentDatagram> pieces;
    std::vector<std::uint8_t> bytes = capture({});
    std::size_t nth = 0;
    for (const SentDatagram& datagram : datagrams) {
      for (const PacketBytes& frame : ethernet_frames(datagram)) {
        if (std::find(left_out.begin(), left_out.end(), nth++) != left_out.end()) continue;
        PacketBytes head(16, 0);
        put_number(head, 0, static_cast<std::uint64_t>(datagram.time / kSecond), 4);
        put_number(head, 8, frame.size(), 4);
        put_number(head, 12, frame.size(), 4);
        bytes.insert(bytes.end(), head.begin(), head.end());
        bytes.insert(bytes.end(), frame.begin(), frame.end());
      }
    }
    write_bytes(folder / "a.pcap", bytes);
    packets::CaptureFile file(folder / "a.pcap");
    packets::Datagram datagram;
    std::size_t read = 0;
    while (file.next(datagram)) {
      ++read;
      CHECK(datagram.payload.size() == 4000);
      CHECK(std::all_of(datagram.payload.begin(), datagram.payload.end(), [](std::uint8_t b) { return b == 7; }));
    }
    return std::pair(read, file.incomplete());
  };
  SentDatagram later = sent;
  later.time = 88 * kSecond;
  CHECK(count({sent, later}, {}) == std::pair<std::size_t, std::uint64_t>(2, 0));
  CHECK(count({sent, later}, {1, 2}) == std::pair<std::size_t, std::uint64_t>(1, 1));
  CHECK(count({sent, sent}, {2}) == std::pair<std::size_t, std::uint64_t>(1, 1));
}

TEST_CASE("a bag of an Ouster's packets is read with the metadata that it holds, or that lies beside it") {
  const auto message_of = [](const PacketBytes& packet) {
    PacketBytes message(4, 0);
    put_number(message, 0, packet.size(), 4);
    message.insert(message.end(), packet.begin(), packet.end());
    return message;
  };
  TemporaryFolder folder;
  const auto write = [&](const std::string& name, bool with_metadata) {
    rosbag::BagWriter bag(folder / name, {rosbag::Compression::none, 4096, true});
    const auto lidar =
        bag.add_connection("/os/lidar_packets", "ouster_ros/PacketMsg", "4f7b5949e76f86d01e96b0e33ba9b5e3", "");
    const auto imu =
        bag.add_connection("/os/imu_packets", "ouster_ros/PacketMsg", "4f7b5949e76f86d01e96b0e33ba9b5e3", "");
    const auto text = bag.add_connection("/os/metadata", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "");
    const std::string json = ouster_metadata("RNG19_RFL8_SIG16_NIR16");
    if (with_metadata) bag.write(text, kStart, message_of({json.begin(), json.end()}));
    for (const SentDatagram& sent : ouster(0.49))
      bag.write(sent.port == 7502 ? lidar : imu, sent.time, message_of(sent.payload));
    bag.close();
  };
  write("a.bag", true);
  const auto source = open_source(folder / "a.bag", lines(16));
  const Read read = read_all(*source);
  REQUIRE(read.sweeps.size() == 5);
  CHECK(read.sweeps[1].points.size() == 512 * 16);
  CHECK(read.imu.size() == 49);
  CHECK(std::abs(read.sweeps[2].points[0].t - (kStart + kDelay + 64 * 16 * 195312)) < 100'000);
  CHECK(inspect(folder / "a.bag", lines(16)).usable);
  write("b.bag", false);
  CHECK(contains(data_error([&] { open_source(folder / "b.bag", lines(16)); }), "b.json"));
  write_text(folder / "b.json", ouster_metadata("RNG19_RFL8_SIG16_NIR16"));
  CHECK(read_all(*open_source(folder / "b.bag", lines(16))).sweeps.size() == 5);
}

TEST_CASE("a sensor's clock is moved by the least delay, follows its drift, and is kept where it is synchronised") {
  packets::SensorClock hourly(3600 * kSecond);
  // An hour ends after 1 s; packets are late by 1 to 5 ms; the sensor runs 50 ppm fast.
  TimeNs worst = 0;
  for (int i = 0; i < 3000; ++i) {
    const TimeNs sensor = i * kSecond / 100, real = sensor - sensor / 20'000;
    const TimeNs received = kStart + 1234 * kSecond + real + 1'000'000 + (i % 7 == 0 ? 0 : 4'000'000);
    const TimeNs wrapped = (3599 * kSecond + sensor) % (3600 * kSecond);
    const TimeNs t = hourly.to_receiver(wrapped, received);
    if (i > 10) worst = std::max(worst, std::abs(t - (kStart + 1234 * kSecond + real + 1'000'000)));
  }
  CHECK(worst < 20'000);
  packets::SensorClock synchronised(0);
  CHECK(synchronised.to_receiver(kStart, kStart + 3'000'000) == kStart);
  CHECK(synchronised.to_receiver(kStart + kSecond, kStart + kSecond + 1'000'000) == kStart + kSecond);
}

}  // namespace aslio::io::test
