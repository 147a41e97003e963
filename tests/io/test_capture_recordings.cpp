// Real network captures in ASLIO_RECORDINGS_DIR, against digests of the vendor's own decoder.
#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "../../framework/io/src/io/packets/capture_file.hpp"
#include "../../framework/io/src/io/packets/ouster.hpp"
#include "../../framework/io/src/io/packets/pcap_reader.hpp"
#include "io/bag_fixture.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::io::test {
namespace {

using aslio::test::recorded;

std::string md5(const std::vector<std::uint32_t>& values) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_Digest(values.data(), values.size() * sizeof(std::uint32_t), digest.data(), &size, EVP_md5(), nullptr);
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::string text_of(const std::filesystem::path& path) {
  const auto bytes = read_bytes(path);
  return {bytes.begin(), bytes.end()};
}

SensorConfig lines(int count) {
  SensorConfig sensor;
  sensor.model.scan_lines = count;
  return sensor;
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

}  // namespace

TEST_CASE("ranges of an Ouster are those of the vendor's decoder, to the bit") {
  for (const std::string name :
       {"OS-1-32-G_v2.1.1_1024x10", "OS-0-32-U1_v2.2.0_1024x10", "OS-0-128-U1_v2.3.0_1024x10"}) {
    INFO(name);
    const auto at = recorded("formats/pcap/" + name + ".pcap");
    const std::string stem = at.parent_path() / name;
    const auto metadata = packets::parse_ouster_metadata(name, text_of(stem + ".json"));
    std::vector<std::uint32_t> ranges(metadata.rows * metadata.columns_per_frame, 0);
    const auto format = packets::make_ouster(metadata);
    packets::CaptureFile capture(at);
    packets::Datagram datagram;
    std::size_t returns = 0, points = 0;
    while (capture.next(datagram)) {
      if (datagram.payload.size() != metadata.packet_bytes()) continue;
      LidarPacket out;
      REQUIRE(format->decode(datagram.payload, 0, 256, out).empty());
      points += out.points.size();
      for (std::size_t i = 0; i < metadata.columns_per_packet; ++i) {
        const auto column = packets::ouster_column(metadata, datagram.payload, i);
        for (std::size_t row = 0; row < metadata.rows; ++row) {
          const std::uint32_t range = packets::ouster_range(metadata, column, row);
          ranges[row * metadata.columns_per_frame + column.measurement] = range;
          returns += range > 0 ? 1 : 0;
        }
      }
    }
    const auto digest = nlohmann::json::parse(text_of(stem + "_digest.json"));
    CHECK(md5(ranges) == digest.at("scans").at(0).at("RANGE"));
    CHECK(points == returns);
    CHECK(points > 10'000);
  }
}

TEST_CASE("captures of an Ouster with its IMU run as one sensor") {
  struct Case {
    std::string name;
    int rows;
    std::size_t sweeps;
  };
  const std::vector<Case> cases{{"formats/pcap/OS-0-32-U1_v2.2.0_1024x10.pcap", 32, 1},
                                {"formats/pcap/OS-0-128-U1_v2.3.0_1024x10.pcap", 128, 1},
                                {"ouster/OS-1-128_v2.3.0_1024x10_lb_n3.pcap", 128, 3},
                                {"ouster/OS-2-128-U1_v2.3.0_1024x10.pcap", 128, 1}};
  for (const Case& one : cases) {
    INFO(one.name);
    const auto source = open_source(recorded(one.name), lines(one.rows));
    const Read read = read_all(*source);
    UNSCOPED_INFO(fmt::format("{} sweeps, {} samples", read.sweeps.size(), read.imu.size()));
    CHECK(read.sweeps.size() == one.sweeps);
    REQUIRE(read.imu.size() >= 9);
    const double rate = static_cast<double>(read.imu.size() - 1) / to_seconds(read.imu.back().t - read.imu.front().t);
    CHECK(rate == Approx(100).epsilon(0.01));
    CHECK(read.imu[3].acc.norm() == Approx(kStandardGravity).epsilon(0.2));
    CHECK(source->notes().malformed_lidar == 0);
    CHECK(std::abs(to_seconds(read.sweeps[0].points.front().t - read.imu.front().t)) < 0.2);
  }
}

TEST_CASE("a bag of an Ouster's packets gives sweeps and IMU samples") {
  const auto source = open_source(recorded("formats/ros1/512x10_raw.bag"), lines(128));
  const Read read = read_all(*source);
  CHECK(read.sweeps.size() >= 1);
  CHECK(read.imu.size() >= 9);
  CHECK(contains(source->notes().verdicts, "lidar packets: Ouster"));
}

TEST_CASE("a capture of an HDL-32E on a turning car") {
  const auto source = open_source(recorded("formats/pcap/hdl32_example.pcap"), lines(32));
  CHECK(contains(source->notes().verdicts, "Velodyne HDL-32E, one return"));
  const Read read = read_all(*source);
  CHECK(read.sweeps.size() == 7);
  REQUIRE(read.imu.size() == 100);
  const double rate = 99 / to_seconds(read.imu.back().t - read.imu.front().t);
  CHECK(rate == Approx(205).epsilon(0.02));
  Vec3 gyro = Vec3::Zero(), acc = Vec3::Zero();
  for (const ImuSample& sample : read.imu) {
    gyro += sample.gyro / 100;
    acc += sample.acc / 100;
  }
  CHECK(gyro.z() == Approx(-0.525).margin(0.01));
  CHECK(acc.z() == Approx(9.1).margin(0.2));
  // Packets are 552.96 us apart; what the receiver's clock adds is not in the times.
  std::size_t points = 0;
  for (const LidarPacket& sweep : read.sweeps) {
    points += sweep.points.size() + sweep.dropped_invalid;
    CHECK(std::is_sorted(sweep.points.begin(), sweep.points.end(),
                         [](const auto& a, const auto& b) { return a.t < b.t; }));
  }
  CHECK(points == 876 * 384);
}

TEST_CASE("an old VLP-16 that calls itself an HDL-32E is known by its rate") {
  const InputReport report = inspect(recorded("formats/pcap/velodyne_vlp16.pcap"), lines(16));
  REQUIRE(report.topics.size() == 1);
  CHECK(contains(report.topics[0].verdicts, "Velodyne VLP-16"));
  CHECK(report.topics[0].malformed == 0);
}

TEST_CASE("odd captures of an Ouster are read or refused with their reason") {
  packets::CaptureFile capture(recorded("formats/pcap/duplicate_id.pcap"));
  packets::Datagram datagram;
  REQUIRE(capture.next(datagram));
  CHECK(datagram.payload.size() == 8448);
  CHECK(!capture.next(datagram));
  CHECK(capture.incomplete() == 1);
  const std::string refusal = data_error([] { open_source(recorded("formats/pcap/imu_zm_no_lidar.pcap"), {}); });
  INFO(refusal);
  CHECK(contains(refusal, "no packets of a LiDAR"));
  CHECK(contains(refusal, "127.0.0.1:7513 (8 datagrams, the last of 452 bytes)"));
  const auto source = open_source(recorded("formats/pcap/crc_test.pcap"), lines(128));
  CHECK(read_all(*source).sweeps.size() >= 1);
  // The metadata lies beside it by the begin of its name.
  const InputReport report = inspect(recorded("formats/pcap/OS-0-32-U1_v2.2.0_1024x10-single-packet.pcap"), lines(32));
  CHECK(report.topics.at(0).points_per_message > 100);
}

}  // namespace aslio::io::test
