#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

using rosbag::BagMessage;
using rosbag::BagReader;
using rosbag::BagWriter;

std::vector<TimeNs> times(BagReader& reader) {
  std::vector<TimeNs> out;
  BagMessage message;
  while (reader.next(message)) out.push_back(message.time);
  return out;
}

/// Writes messages of one byte at the given times, one chunk each.
void write_times(const std::filesystem::path& path, const std::vector<TimeNs>& at, rosbag::WriterOptions options) {
  BagWriter bag(path, options);
  const auto id = bag.add_connection("/a", "std_msgs/UInt8", "7c8164229e7d2c17eb95e9231617fdee", "uint8 data\n");
  for (std::size_t i = 0; i < at.size(); ++i) {
    const std::uint8_t byte = static_cast<std::uint8_t>(i);
    bag.write(id, at[i], {&byte, 1});
  }
  bag.close();
}

}  // namespace

TEST_CASE("what is written is read back, byte for byte and in time") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  const bool index = GENERATE(true, false);
  TemporaryFolder folder;
  Recording recording;
  recording.points = 400;  // 7.6 kB: chunks of one message, and larger than the window of small messages when joined
  recording.options = {compression, 20'000, index};
  recording.write(folder / "a.bag");
  BagReader reader(folder / "a.bag");
  REQUIRE(reader.connections().size() == 2);
  CHECK(reader.connections()[1].type == "livox_ros_driver/CustomMsg");
  CHECK(reader.connections()[1].definition == rosbag::kLivoxCustomMsg.definition);
  CHECK(*reader.begin_time() == kStart);
  CHECK(*reader.end_time() == kStart + 199 * kSecond / 100);
  std::size_t imu = 0, lidar = 0;
  BagMessage message;
  std::vector<std::uint8_t> expected;
  while (reader.next(message)) {
    if (message.connection == 0) {
      const TimeNs stamp = kStart + static_cast<TimeNs>(imu) * kSecond / 100;
      rosbag::encode_imu({static_cast<std::uint32_t>(imu), stamp, "imu"}, recording.gyro, recording.acc, expected);
      CHECK(message.time == stamp);
      ++imu;
    } else {
      const TimeNs stamp = kStart + static_cast<TimeNs>(lidar) * kSecond / 10;
      expected = livox_message(stamp, stamp, 400);
      ++lidar;
    }
    REQUIRE(std::equal(message.bytes.begin(), message.bytes.end(), expected.begin(), expected.end()));
  }
  CHECK(imu == 200);
  CHECK(lidar == 20);
  CHECK(reader.status() == InputStatus::complete);
  CHECK(reader.warnings().empty() == index);
}

TEST_CASE("messages come by record time across chunks") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  const std::vector<TimeNs> at{50, 10, 40, 20, 30, 60, 5, 70};
  SECTION("one chunk per message") { write_times(folder / "a.bag", at, {compression, 1, true}); }
  SECTION("one chunk per message, no index") { write_times(folder / "a.bag", at, {compression, 1, false}); }
  SECTION("three messages per chunk") { write_times(folder / "a.bag", at, {compression, 150, true}); }
  SECTION("one chunk") { write_times(folder / "a.bag", at, {compression, 100'000, true}); }
  BagReader reader(folder / "a.bag");
  CHECK(times(reader) == std::vector<TimeNs>{5, 10, 20, 30, 40, 50, 60, 70});
}

TEST_CASE("messages of equal time keep the order of the file") {
  TemporaryFolder folder;
  write_times(folder / "a.bag", std::vector<TimeNs>(20, 7), {rosbag::Compression::none, 100, true});
  BagReader reader(folder / "a.bag");
  BagMessage message;
  for (std::uint8_t i = 0; i < 20; ++i) {
    REQUIRE(reader.next(message));
    REQUIRE(message.bytes[0] == i);
  }
}

TEST_CASE("when overlapping chunks exceed the memory, all messages still come, and it is said") {
  TemporaryFolder folder;
  std::vector<TimeNs> at;
  for (TimeNs k = 0; k < 200; ++k) at.push_back(k % 2 == 0 ? 0 : 1'000'000 + k);
  write_times(folder / "a.bag", at, {rosbag::Compression::lz4, 80, true});
  rosbag::Limits limits;
  limits.merged_chunk_bytes = 500;
  BagReader reader(folder / "a.bag", limits);
  CHECK(times(reader).size() == at.size());
  CHECK(contains(reader.warnings(), "approximate order"));
}

TEST_CASE("reading can be restricted and restarted") {
  TemporaryFolder folder;
  Recording{}.write(folder / "a.bag");
  BagReader reader(folder / "a.bag");
  const std::uint32_t lidar = 1, imu = 0;
  reader.select({&lidar, 1});
  CHECK(times(reader).size() == 20);
  reader.select({&imu, 1});
  CHECK(times(reader).size() == 200);
  reader.select({&lidar, 1});
  CHECK(times(reader).size() == 20);
}

TEST_CASE("other files are named for what they are") {
  TemporaryFolder folder;
  const auto refusal = [&](const std::string& start) {
    write_bytes(folder / "x", std::vector<std::uint8_t>(start.begin(), start.end()));
    return data_error([&] { BagReader{folder / "x"}; });
  };
  CHECK(contains(refusal(""), "empty"));
  CHECK(contains(refusal("#ROSBAG V1.2\n"), "rosbag fix"));
  CHECK(contains(refusal("SQLite format 3"), "a rosbag2 database"));
  CHECK(contains(refusal("\x89MCAP0\r\n"), "MCAP"));
  CHECK(contains(refusal("\xFD"
                         "7zXZ and more"),
                 "unpack it first: `xz -dk FILE`"));
  CHECK(contains(refusal("\x1F\x8B and more"), "`gunzip -k FILE`"));
  CHECK(contains(refusal("hello, this is text"), "of no known recording: a ROS1 bag (.bag), an MCAP file (.mcap)"));
  CHECK(contains(refusal("# .PCD v0.7 - Point Cloud"), "give the folder that holds all scans"));
  CHECK(contains(refusal("LASF and more"), "a point cloud without the times of a recording"));
  CHECK(contains(refusal("version https://git-lfs.github.com/spec/v1"), "git lfs pull"));
  const std::string livox("livox_tech\0\0\0\0\0\0", 16);
  CHECK(contains(refusal(livox + std::string("\1\1\0\0 and more", 13)), "`lvx_to_rosbag`"));
  CHECK(contains(refusal(livox + std::string("\2\0\0\0 and more", 13)), "an LVX2 file of Livox, which has points"));
  CHECK(contains(data_error([&] { BagReader{folder / "absent.bag"}; }), "absent.bag"));
  CHECK(contains(data_error([&] { BagReader{folder.path()}; }), "not a regular file"));
}

TEST_CASE("the writer refuses times a bag cannot hold") {
  TemporaryFolder folder;
  BagWriter bag(folder / "a.bag");
  const auto id = bag.add_connection("/a", "x/Y", "0", "");
  CHECK(contains(data_error([&] { bag.write(id, -1, {}); }), "-1 ns"));
  CHECK(contains(data_error([&] { bag.write(id + 1, 0, {}); }), "no such connection"));
}

TEST_CASE("control characters in names do not reach the terminal") {
  TemporaryFolder folder;
  {
    BagWriter bag(folder / "a.bag");
    const std::uint8_t byte = 0;
    bag.write(bag.add_connection("/a\x1b[2J", "x/Y\n", "0", ""), 1, {&byte, 1});
    bag.close();
  }
  BagReader reader(folder / "a.bag");
  CHECK(reader.connections()[0].topic == "/a?[2J");
  CHECK(reader.connections()[0].type == "x/Y?");
}

}  // namespace aslio::io::test
