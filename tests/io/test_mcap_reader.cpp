#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "io/mcap_fixture.hpp"
#include "mcap/reader.hpp"

namespace aslio::io::test {
namespace {

using mcap::McapReader;

const std::vector<std::string> kCompressions{"", "lz4", "zstd"};

std::vector<TimeNs> times(MessageReader& reader) {
  std::vector<TimeNs> out;
  for (const Read& read : read_messages(reader)) out.push_back(read.time);
  return out;
}

/// Messages of one byte at the given times; a chunk ends when it is as long.
ByteVector with_times(const std::vector<TimeNs>& at, const McapOptions& options) {
  McapWriter writer(options);
  const std::uint16_t id =
      writer.add_channel("/a", writer.add_schema("std_msgs/UInt8", "ros1msg", "uint8 data\n"), "ros1");
  for (std::size_t i = 0; i < at.size(); ++i) writer.write(id, at[i], {static_cast<std::uint8_t>(i)});
  return writer.close();
}

/// Position of the chunk record of that number.
std::size_t chunk_position(const ByteVector& bytes, int number) {
  for (std::size_t at = 8; at + 9 <= bytes.size();) {
    if (bytes[at] == 0x06 && number-- == 0) return at;
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 8; ++i) length |= static_cast<std::uint64_t>(bytes[at + 1 + i]) << (8 * i);
    at += 9 + static_cast<std::size_t>(length);
  }
  return 0;
}

}  // namespace

TEST_CASE("what is written into an MCAP file is read back, byte for byte and in time") {
  McapOptions options;
  options.compression = GENERATE(from_range(kCompressions));
  options.chunks = GENERATE(true, false);
  options.summary = GENERATE(true, false);
  options.message_indexes = GENERATE(true, false);
  options.crc = GENERATE(true, false);
  TemporaryFolder folder;
  // One that is larger than the window of small messages.
  McapWriter writer(options);
  const std::uint16_t schema = writer.add_schema("x/Y", "ros1msg", "uint8[] data\n");
  const std::uint16_t first = writer.add_channel("/first", schema, "ros1", {{"md5sum", "0123"}});
  std::vector<Read> expected;
  const auto write = [&](std::uint16_t channel, std::size_t size) {
    const TimeNs time = kStart + static_cast<TimeNs>(expected.size()) * kSecond;
    expected.push_back({channel, time, ByteVector(size, static_cast<std::uint8_t>(expected.size()))});
    writer.write(channel, time, expected.back().bytes);
  };
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{3000}, std::size_t{100'000}}) {
    write(first, size);
  }
  const std::uint16_t second = writer.add_channel("/second", schema, "cdr");
  for (std::size_t i = 0; i < 40; ++i) write(i % 3 == 0 ? first : second, 300);
  write_bytes(folder / "a.mcap", writer.close());

  McapReader reader(folder / "a.mcap");
  REQUIRE(reader.connections().size() == 2);
  CHECK(*reader.begin_time() == kStart);
  CHECK(*reader.end_time() == kStart + 43 * kSecond);
  CHECK(read_messages(reader) == expected);
  CHECK(reader.status() == InputStatus::complete);
  CHECK(reader.warnings().empty() == (options.summary || !options.chunks));
  RawMessage message;
  CHECK_FALSE(reader.next(message));
}

TEST_CASE("channels tell of topic, type, definition, checksum and encoding") {
  TemporaryFolder folder;
  McapWriter writer({"zstd"});
  const std::uint16_t imu = writer.add_schema("sensor_msgs/Imu", "ros1msg", "Header header\n");
  const std::uint16_t cloud = writer.add_schema("sensor_msgs/msg/PointCloud2", "ros2msg", "x");
  writer.add_channel("/imu", imu, "ros1", {{"md5sum", "6a62"}, {"callerid", "/a"}});
  writer.add_channel("/imu", imu, "ros1");
  writer.add_channel("/points", cloud, "cdr", {{"offered_qos_profiles", "- history: 3\n"}});
  writer.add_channel("/log\x1b[2J", 0, "json");
  for (std::uint16_t id = 0; id < 4; ++id) writer.write(id, id, {});
  write_bytes(folder / "a.mcap", writer.close());
  McapReader reader(folder / "a.mcap");
  const std::vector<Connection>& all = reader.connections();
  REQUIRE(all.size() == 4);
  CHECK(all[0].topic == "/imu");
  CHECK(all[1].topic == "/imu");
  CHECK(all[0].type == "sensor_msgs/Imu");
  CHECK(all[0].definition == "Header header\n");
  CHECK(all[0].md5 == "6a62");
  CHECK(all[1].md5.empty());
  CHECK(all[2].type == "sensor_msgs/msg/PointCloud2");
  CHECK(all[3].topic == "/log?[2J");
  CHECK(all[3].type.empty());
  CHECK(all[3].definition.empty());
  const std::vector<Encoding> encodings{Encoding::ros1, Encoding::ros1, Encoding::cdr, Encoding::other};
  RawMessage message;
  for (std::uint32_t id = 0; id < 4; ++id) {
    CHECK(all[id].id == id);
    CHECK(all[id].encoding == encodings[id]);
    REQUIRE(reader.next(message));
    CHECK(message.connection == id);
    CHECK(message.encoding == encodings[id]);
  }
}

TEST_CASE("messages of an MCAP file come by log time across chunks") {
  McapOptions options;
  options.compression = GENERATE(from_range(kCompressions));
  options.summary = GENERATE(true, false);
  options.message_indexes = GENERATE(true, false);
  options.chunk_bytes = GENERATE(1U, 100U, 100'000U);
  options.chunks = GENERATE(true, false);
  TemporaryFolder folder;
  write_bytes(folder / "a.mcap", with_times({50, 10, 40, 20, 30, 60, 5, 70}, options));
  McapReader reader(folder / "a.mcap");
  CHECK(*reader.begin_time() == 5);
  CHECK(*reader.end_time() == 70);
  CHECK(times(reader) == std::vector<TimeNs>{5, 10, 20, 30, 40, 50, 60, 70});
}

TEST_CASE("messages of equal log time keep the order of the file") {
  McapOptions options{"lz4"};
  options.chunk_bytes = GENERATE(1U, 90U);
  options.chunks = GENERATE(true, false);
  TemporaryFolder folder;
  std::vector<TimeNs> at(20, 7);
  // These make a later chunk the one that begins first.
  at[10] = 3;
  at[15] = 1;
  write_bytes(folder / "a.mcap", with_times(at, options));
  McapReader reader(folder / "a.mcap");
  const std::vector<Read> all = read_messages(reader);
  REQUIRE(all.size() == 20);
  CHECK(all[0].bytes[0] == 15);
  CHECK(all[1].bytes[0] == 10);
  for (std::size_t i = 3; i < all.size(); ++i) CHECK(all[i].bytes[0] > all[i - 1].bytes[0]);
}

TEST_CASE("when overlapping chunks of an MCAP file exceed the memory, all messages still come, and it is said") {
  McapOptions options{"zstd"};
  options.chunk_bytes = 80;
  TemporaryFolder folder;
  std::vector<TimeNs> at;
  for (TimeNs k = 0; k < 200; ++k) at.push_back(k % 2 == 0 ? 0 : 1'000'000 + k);
  write_bytes(folder / "a.mcap", with_times(at, options));
  mcap::Limits limits;
  limits.merged_chunk_bytes = 500;
  McapReader reader(folder / "a.mcap", limits);
  CHECK(times(reader).size() == at.size());
  CHECK(contains(reader.warnings(), "approximate order"));
}

TEST_CASE("reading of an MCAP file can be restricted and restarted") {
  McapOptions options;
  options.compression = GENERATE(from_range(kCompressions));
  options.chunks = GENERATE(true, false);
  TemporaryFolder folder;
  write_bytes(folder / "a.mcap", small_mcap(options, 31));
  McapReader reader(folder / "a.mcap");
  const std::uint32_t a = 0, b = 1;
  reader.select({&a, 1});
  CHECK(times(reader).size() == 16);
  reader.select({&b, 1});
  CHECK(times(reader).size() == 15);
  reader.select({});
  CHECK(times(reader).empty());
  reader.select({&a, 1});
  CHECK(times(reader).size() == 16);
  CHECK(reader.warnings().empty());
}

TEST_CASE("chunks without a selected channel are not read") {
  McapOptions options{"zstd"};
  options.summary = GENERATE(true, false);
  TemporaryFolder folder;
  McapWriter writer(options);
  const std::uint16_t a = writer.add_channel("/a", 0, "json"), b = writer.add_channel("/b", 0, "json");
  writer.write(a, 1, ByteVector(50, 1));
  writer.end_chunk();
  writer.write(b, 2, ByteVector(50, 2));
  writer.end_chunk();
  writer.write(a, 3, ByteVector(50, 3));
  ByteVector bytes = writer.close();
  const std::size_t at = chunk_position(bytes, 1);
  REQUIRE(at > 0);
  bytes[at + 9 + 45] ^= 0x40U;  // compressed data
  write_bytes(folder / "a.mcap", bytes);
  McapReader reader(folder / "a.mcap");
  const std::uint32_t first = a, second = b;
  reader.select({&first, 1});
  CHECK(times(reader) == std::vector<TimeNs>{1, 3});
  reader.select({&second, 1});
  RawMessage message;
  CHECK(contains(data_error([&] { reader.next(message); }), "damaged chunk at offset " + std::to_string(at)));
}

TEST_CASE("messages outside chunks are read beside those in chunks, with an index and without") {
  McapOptions options{"lz4"};
  options.summary = GENERATE(true, false);
  TemporaryFolder folder;
  McapWriter writer(options);
  const std::uint16_t a = writer.add_channel("/a", 0, "json");
  writer.write(a, 10, {1});
  writer.end_chunk();
  writer.add_record(0x09, ByteVector(200'000, 9));  // an attachment
  writer.write_outside(a, 15, {2});
  writer.add_record(0x0C, Packed().text("name").map({{"k", "v"}}).bytes());
  writer.add_record(0x88, {1, 2, 3});
  for (TimeNs t = 0; t < 10'000; ++t) writer.write_outside(a, 16 + t, {3});
  writer.write(a, 12, {4});
  write_bytes(folder / "a.mcap", writer.close());
  McapReader reader(folder / "a.mcap");
  const std::vector<TimeNs> all = times(reader);
  CHECK(all.size() == 10'003);
  CHECK(std::is_sorted(all.begin(), all.end()));
  CHECK(*reader.end_time() == 16 + 9'999);
  CHECK(reader.warnings().empty() == options.summary);
}

TEST_CASE("a description that is repeated alike is fine, another one is damage") {
  const bool in_chunk = GENERATE(true, false);
  const bool summary = GENERATE(true, false);
  const bool alike = GENERATE(true, false);
  const std::uint8_t op = GENERATE(std::uint8_t{3}, std::uint8_t{4});
  TemporaryFolder folder;
  McapOptions options{"zstd"};
  options.summary = summary;
  McapWriter writer(options);
  const std::uint16_t schema = writer.add_schema("x/Y", "ros1msg", "z");
  const std::uint16_t a = writer.add_channel("/a", schema, "ros1", {{"k", "v"}, {"l", "w"}});
  writer.write(a, 1, {1});
  writer.end_chunk();
  const std::string last = alike ? "w" : "other";
  const ByteVector content =
      op == 3 ? Packed().number(schema).text("x/Y").text("ros1msg").text(alike ? "z" : "other").bytes()
              : Packed().number(a).number(schema).text("/a").text("ros1").map({{"k", "v"}, {"l", last}}).bytes();
  if (in_chunk) {
    writer.add_to_chunk(op, content);
  } else {
    writer.add_record(op, content);
  }
  writer.write(a, 2, {2});
  write_bytes(folder / "a.mcap", writer.close());
  const ReadFile file = read_mcap(folder / "a.mcap");
  if (alike) {
    CHECK(file.refusal.empty());
    CHECK(file.messages.size() == 2);
  } else {
    CHECK(contains(file.refusal, "described twice, with different content"));
    CHECK(contains(file.refusal, "offset"));
  }
}

TEST_CASE("large and very compressible chunks are read, beyond a limit it is named") {
  TemporaryFolder folder;
  McapOptions options{"zstd"};
  options.chunk_bytes = 200U << 20U;
  McapWriter writer(options);
  const std::uint16_t a = writer.add_channel("/map", 0, "json");
  writer.write(a, 1, ByteVector(80U << 20U, 0xFF));
  write_bytes(folder / "a.mcap", writer.close());
  REQUIRE(std::filesystem::file_size(folder / "a.mcap") < 20'000);
  CHECK(read_mcap(folder / "a.mcap").messages.size() == 1);

  mcap::Limits limits;
  limits.chunk_bytes = 64U << 20U;
  McapReader reader(folder / "a.mcap", limits);
  RawMessage message;
  const std::string error = data_error([&] { reader.next(message); });
  CHECK(contains(error, "the limit of this reader is 67108864"));
  CHECK(contains(error, "mcap compress"));
  CHECK_FALSE(contains(error, "damaged"));
}

TEST_CASE("a recording is opened as what its first bytes tell") {
  TemporaryFolder folder;
  write_bytes(folder / "a.bag", small_mcap({"zstd"}));
  const auto reader = open_messages(folder / "a.bag");
  CHECK(reader->kind() == "MCAP file");
  CHECK(read_messages(*reader).size() == 20);
  Recording{}.write(folder / "b.mcap");
  CHECK(open_messages(folder / "b.mcap")->kind() == "ROS1 bag");
  const auto refusal = [&](const std::string& start) {
    write_bytes(folder / "x", ByteVector(start.begin(), start.end()));
    return data_error([&] { open_messages(folder / "x"); });
  };
  CHECK(contains(refusal("\x89MCAP1\r\n and more"), "another version"));
  CHECK(contains(refusal("\x89MCAP0\r"), "ends inside its first 8 bytes"));
  CHECK(contains(refusal("\x89MCAP0\r\n"), "ends inside its header"));
  CHECK(contains(refusal("hello, this is text"), "of no known recording"));
  write_bytes(folder / "x", {1, 2, 3});
  CHECK(contains(data_error([&] { McapReader{folder / "x"}; }), "not an MCAP file"));
  write_bytes(folder / "x", {});
  CHECK(contains(data_error([&] { McapReader{folder / "x"}; }), "empty"));
}

TEST_CASE("an MCAP file of messages that odometry needs is played") {
  TemporaryFolder folder;
  McapOptions options;
  options.compression = GENERATE(from_range(kCompressions));
  Recording recording;
  recording.write(folder / "a.bag");
  const auto bag = open_messages(folder / "a.bag");
  McapWriter writer(options);
  for (const Connection& c : bag->connections()) {
    writer.add_channel(c.topic, writer.add_schema(c.type, "ros1msg", c.definition), "ros1", {{"md5sum", c.md5}});
  }
  for (const Read& m : read_messages(*bag)) writer.write(static_cast<std::uint16_t>(m.connection), m.time, m.bytes);
  write_bytes(folder / "a.mcap", writer.close());
  const auto expected = open_source(folder / "a.bag", {}), source = open_source(folder / "a.mcap", {});
  const Counts a = drain(*expected), b = drain(*source);
  CHECK(b.imu == a.imu);
  CHECK(b.points == a.points);
  CHECK(b.packets == 20);
  CHECK(inspect(folder / "a.mcap").kind == "MCAP file");
}

}  // namespace aslio::io::test
