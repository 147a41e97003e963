// CDR against the implementation that ROS2 uses.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <array>
#include <catch2/catch.hpp>
#include <functional>

#include "../../framework/io/src/io/decode/cloud.hpp"
#include "../../framework/io/src/io/decode/decode.hpp"
#include "aslio/io/cdr.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

using eprosima::fastcdr::Cdr;
using Bytes = std::vector<std::uint8_t>;

constexpr TimeNs kStamp = kStart + 123'456'789;

Bytes serialised(Cdr::Endianness order, const std::function<void(Cdr&)>& fill) {
  std::array<char, 4096> memory{};  // padding stays as it is
  eprosima::fastcdr::FastBuffer buffer(memory.data(), memory.size());
  Cdr cdr(buffer, order, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << static_cast<std::int32_t>(kStamp / kSecond) << static_cast<std::uint32_t>(kStamp % kSecond)
      << std::string("frame");
  fill(cdr);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(buffer.getBuffer());
  return {begin, begin + cdr.getSerializedDataLength()};
}

Connection ros1(const rosbag::MessageType& type) {
  return {0, "/t", std::string(type.name), std::string(type.md5), "", Encoding::ros1};
}

void fill_imu(Cdr& cdr) {
  cdr << std::array<double, 4>{0, 0, 0, 1} << std::array<double, 9>{-1, 0, 0, 0, 0, 0, 0, 0, 0};
  cdr << std::array<double, 3>{0.1, -0.2, 0.3} << std::array<double, 9>{};
  cdr << std::array<double, 3>{1, 2, 9.5} << std::array<double, 9>{};
}

void fill_livox(Cdr& cdr) {
  cdr << static_cast<std::uint64_t>(kStamp) << std::uint32_t{3};
  cdr << std::uint8_t{7} << std::array<std::uint8_t, 3>{} << std::uint32_t{3};
  for (std::uint32_t i = 0; i < 3; ++i) {
    cdr << i * 1000U << 1.0F + static_cast<float>(i) << 2.0F << 3.0F << std::uint8_t{9} << std::uint8_t{0x10}
        << static_cast<std::uint8_t>(i);
  }
}

std::vector<rosbag::LivoxPoint> livox_points() {
  std::vector<rosbag::LivoxPoint> points(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    points[i] = {i * 1000, 1.0F + static_cast<float>(i), 2, 3, 9, 0x10, static_cast<std::uint8_t>(i)};
  }
  return points;
}

}  // namespace

TEST_CASE("an Imu is serialised as by the reference, and read in both byte orders") {
  Bytes message, converted;
  rosbag::encode_imu({5, kStamp, "frame"}, Vec3(0.1, -0.2, 0.3), Vec3(1, 2, 9.5), message);
  CHECK(to_cdr(ros1(rosbag::kImu), message, converted).empty());
  CHECK(converted == serialised(Cdr::LITTLE_ENDIANNESS, &fill_imu));
  for (const auto order : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    const Bytes bytes = serialised(order, &fill_imu);
    ImuSample sample;
    CHECK(decode::decode_imu({bytes, Encoding::cdr}, sample).empty());
    CHECK(sample.t == kStamp);
    CHECK(sample.gyro == Vec3(0.1, -0.2, 0.3));
    CHECK(sample.acc == Vec3(1, 2, 9.5));
  }
}

TEST_CASE("a CustomMsg is serialised as by the reference, and read in both byte orders") {
  Bytes message, converted;
  rosbag::encode_livox({5, kStamp, "frame"}, kStamp, 7, livox_points(), message);
  CHECK(to_cdr(ros1(rosbag::kLivoxCustomMsg), message, converted).empty());
  CHECK(converted == serialised(Cdr::LITTLE_ENDIANNESS, &fill_livox));
  for (const auto order : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    const Bytes bytes = serialised(order, &fill_livox);
    LidarPacket packet;
    decode::LivoxFacts facts;
    CHECK(decode::decode_livox({bytes, Encoding::cdr}, {}, packet, facts).empty());
    CHECK(facts.lidar_id == 7);
    REQUIRE(packet.points.size() == 3);
    CHECK(packet.points[2].x == 3.0F);
    CHECK(packet.points[2].t == kStamp + 2000);
    CHECK(packet.points[2].line == 2);
  }
}

TEST_CASE("a PointCloud2 is serialised as by the reference") {
  rosbag::CloudLayout layout;
  layout.width = 2;
  layout.point_step = 13;
  layout.row_step = 26;
  layout.fields = {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"tag", 12, 2}};
  const Bytes data(26, 1);
  Bytes message, converted;
  rosbag::encode_point_cloud2({5, kStamp, "frame"}, layout, data, message);
  CHECK(to_cdr(ros1(rosbag::kPointCloud2), message, converted).empty());
  const auto fill = [&](Cdr& cdr) {
    cdr << std::uint32_t{1} << std::uint32_t{2} << std::uint32_t{4};
    for (const rosbag::PointField& f : layout.fields) cdr << f.name << f.offset << f.datatype << f.count;
    cdr << false << std::uint32_t{13} << std::uint32_t{26} << data << true;
  };
  CHECK(converted == serialised(Cdr::LITTLE_ENDIANNESS, fill));
  for (const auto order : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    const Bytes bytes = serialised(order, fill);
    decode::CloudView view;
    bool systematic = false;
    CHECK(decode::parse_cloud({bytes, Encoding::cdr}, view, systematic).empty());
    CHECK(view.width == 2);
    CHECK(view.frame == "frame");
    CHECK(view.data.size() == 26);
  }
}

}  // namespace aslio::io::test
