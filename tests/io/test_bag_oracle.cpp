// The reference implementation writes, ours reads; ours writes, the reference reads.
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <catch2/catch.hpp>

#include "io/bag_fixture.hpp"

namespace {

struct StoredMessage {
  aslio::io::rosbag::MessageType type;
  std::vector<std::uint8_t> bytes;
};

}  // namespace

namespace ros {
namespace message_traits {
template <>
struct IsMessage<StoredMessage> : TrueType {};
template <>
struct IsMessage<const StoredMessage> : TrueType {};
template <>
struct MD5Sum<StoredMessage> {
  static const char* value(const StoredMessage& m) { return m.type.md5.data(); }
};
template <>
struct DataType<StoredMessage> {
  static const char* value(const StoredMessage& m) { return m.type.name.data(); }
};
template <>
struct Definition<StoredMessage> {
  static const char* value(const StoredMessage& m) { return m.type.definition.data(); }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<StoredMessage> {
  template <typename Stream>
  static void write(Stream& stream, const StoredMessage& m) {
    std::copy(m.bytes.begin(), m.bytes.end(), stream.advance(static_cast<std::uint32_t>(m.bytes.size())));
  }
  static std::uint32_t serializedLength(const StoredMessage& m) { return static_cast<std::uint32_t>(m.bytes.size()); }
};
}  // namespace serialization
}  // namespace ros

namespace aslio::io::test {
namespace {

struct Heard {
  std::string topic;
  TimeNs time = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const Heard&) const = default;
};

ros::Time ros_time(TimeNs t) {
  return {static_cast<std::uint32_t>(t / kSecond), static_cast<std::uint32_t>(t % kSecond)};
}

/// Record times run ahead and back by up to 0.2 s, so that chunks overlap; all differ.
void write_by_reference(const std::filesystem::path& path, ::rosbag::compression::CompressionType compression) {
  ::rosbag::Bag bag(path.string(), ::rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(30'000);
  StoredMessage message;
  for (int i = 0; i < 600; ++i) {
    const TimeNs stamp = kStart + i * kSecond / 100;
    const TimeNs recorded = stamp + (i * 7919 % 20) * 10'000'000 + i;
    if (i % 10 == 0) {
      message = {rosbag::kLivoxCustomMsg, livox_message(stamp, stamp, 300)};
      bag.write("/livox/lidar", ros_time(recorded), message);
    } else {
      message.type = rosbag::kImu;
      rosbag::encode_imu({0, stamp, "imu"}, Vec3::Constant(0.001 * i), Vec3(0, 0, 9.8), message.bytes);
      bag.write("/livox/imu", ros_time(recorded), message);
    }
  }
  bag.close();
}

std::vector<Heard> heard_by_reference(const std::filesystem::path& path) {
  ::rosbag::Bag bag(path.string(), ::rosbag::bagmode::Read);
  std::vector<Heard> heard;
  for (const ::rosbag::MessageInstance& m : ::rosbag::View(bag)) {
    Heard one{m.getTopic(), static_cast<TimeNs>(m.getTime().toNSec()), std::vector<std::uint8_t>(m.size())};
    ros::serialization::OStream stream(one.bytes.data(), m.size());
    m.write(stream);
    heard.push_back(std::move(one));
  }
  return heard;
}

std::vector<Heard> heard_by_us(const std::filesystem::path& path) {
  rosbag::BagReader reader(path);
  std::vector<Heard> heard;
  rosbag::BagMessage message;
  while (reader.next(message)) {
    const auto& all = reader.connections();
    const auto at = std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.id == message.connection; });
    heard.push_back({at->topic, message.time, {message.bytes.begin(), message.bytes.end()}});
  }
  CHECK(reader.status() == InputStatus::complete);
  return heard;
}

}  // namespace

TEST_CASE("bags of librosbag are read as librosbag reads them") {
  const auto compression =
      GENERATE(::rosbag::compression::Uncompressed, ::rosbag::compression::BZ2, ::rosbag::compression::LZ4);
  TemporaryFolder folder;
  write_by_reference(folder / "a.bag", compression);
  const auto expected = heard_by_reference(folder / "a.bag");
  REQUIRE(expected.size() == 600);
  CHECK(heard_by_us(folder / "a.bag") == expected);
}

TEST_CASE("a bag of librosbag without its index is read the same") {
  const auto compression =
      GENERATE(::rosbag::compression::Uncompressed, ::rosbag::compression::BZ2, ::rosbag::compression::LZ4);
  TemporaryFolder folder;
  write_by_reference(folder / "a.bag", compression);
  const auto expected = heard_by_reference(folder / "a.bag");
  // As an interrupted recorder leaves it: the header still says 0 for the position of the index.
  auto bytes = read_bytes(folder / "a.bag");
  const std::string key = "index_pos=";
  const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
  REQUIRE(at != bytes.end());
  std::fill_n(at + static_cast<std::ptrdiff_t>(key.size()), 8, std::uint8_t{0});
  write_bytes(folder / "b.bag", bytes);
  CHECK(heard_by_us(folder / "b.bag") == expected);
}

TEST_CASE("librosbag reads our bags") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  Recording recording;
  recording.points = 500;
  recording.options = {compression, 30'000, true};
  recording.write(folder / "a.bag");
  const auto expected = heard_by_reference(folder / "a.bag");
  CHECK(expected.size() == 220);
  CHECK(heard_by_us(folder / "a.bag") == expected);
}

}  // namespace aslio::io::test
