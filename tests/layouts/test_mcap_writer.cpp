/// MCAP by its specification: records, their order, checksums and the summary, taken apart without the reader.
#include <catch2/catch.hpp>
#include <map>

#include "aslio/core/errors.hpp"
#include "aslio/io/mcap/writer.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

struct Rec {
  int op = 0;
  std::size_t position = 0, content = 0, bytes = 0;
};

std::vector<std::uint8_t> file_bytes(const std::filesystem::path& file) {
  const std::string text = text_of(file);
  return {text.begin(), text.end()};
}

std::vector<Rec> records(std::span<const std::uint8_t> file) {
  std::vector<Rec> all;
  for (std::size_t next = 8; next + 9 <= file.size() - 8;) {
    const Rec rec{file[next], next, next + 9, static_cast<std::size_t>(at<std::uint64_t>(file, next + 1))};
    all.push_back(rec);
    next = rec.content + rec.bytes;
  }
  return all;
}

/// CRC-32 bit by bit: no library that the writer uses.
std::uint32_t crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0xFFFFFFFF;
  for (const std::uint8_t byte : bytes) {
    value ^= byte;
    for (int bit = 0; bit < 8; ++bit) value = (value & 1U) != 0 ? (value >> 1U) ^ 0xEDB88320U : value >> 1U;
  }
  return ~value;
}

io::Connection channel(const std::string& topic, io::Encoding encoding) {
  return {0,
          topic,
          encoding == io::Encoding::ros1 ? "std_msgs/String" : "std_msgs/msg/String",
          encoding == io::Encoding::ros1 ? "992ce8a1687cec8c8bd883ec73ca41d1" : "",
          "string data\n",
          encoding};
}

/// Two channels of one encoding, ten messages, some four to a chunk.
std::vector<std::uint8_t> small_file(const TemporaryFolder& folder, io::Encoding encoding,
                                     io::mcap::Compression compression) {
  io::mcap::McapWriter writer(folder / "small.mcap", {.compression = compression, .chunk_bytes = 300});
  const auto a = writer.add(channel("/a", encoding)), b = writer.add(channel("/b", encoding));
  for (std::uint8_t i = 0; i < 10; ++i) {
    const std::vector<std::uint8_t> bytes(40, i);
    writer.write(i % 2 == 0 ? a : b, 1000 + i, bytes);
  }
  writer.close();
  return file_bytes(folder / "small.mcap");
}

}  // namespace

TEST_CASE("layouts: an MCAP file has the records of its specification") {
  const TemporaryFolder folder;
  const auto bytes = small_file(folder, io::Encoding::cdr, io::mcap::Compression::none);
  const std::span<const std::uint8_t> file = bytes;
  const std::string magic = "\x89MCAP0\r\n";
  CHECK(std::string(bytes.begin(), bytes.begin() + 8) == magic);
  CHECK(std::string(bytes.end() - 8, bytes.end()) == magic);
  const auto all = records(file);
  std::map<int, std::size_t> counts;
  for (const Rec& rec : all) ++counts[rec.op];
  REQUIRE(all.front().op == 0x01);
  CHECK(std::string(bytes.begin() + 21, bytes.begin() + 25) == "ros2");
  REQUIRE(all.back().op == 0x02);
  CHECK(counts[0x06] >= 3);             // chunks
  CHECK(counts[0x06] == counts[0x08]);  // and their indexes
  CHECK(counts[0x0F] == 1);             // end of data
  CHECK(counts[0x03] == 2);             // schemas and channels, in the summary
  CHECK(counts[0x04] == 2);
  CHECK(counts[0x0B] == 1);  // statistics
  CHECK(counts[0x0E] == 4);  // offsets of the four groups
  const Rec& footer = all.back();
  const auto summary = at<std::uint64_t>(file, footer.content), offsets = at<std::uint64_t>(file, footer.content + 8);
  CHECK(at<std::uint32_t>(file, footer.content + 16) == crc(file.subspan(summary, footer.content + 16 - summary)));
  for (const Rec& rec : all) {
    if (rec.op == 0x0F) {
      CHECK(at<std::uint32_t>(file, rec.content) == crc(file.first(rec.position)));
      CHECK(rec.content + rec.bytes == summary);
    }
    if (rec.op == 0x0B) {
      CHECK(at<std::uint64_t>(file, rec.content) == 10);
      CHECK(at<std::uint16_t>(file, rec.content + 8) == 2);
      CHECK(at<std::uint32_t>(file, rec.content + 10) == 2);
      CHECK(at<std::uint32_t>(file, rec.content + 22) == counts[0x06]);
      CHECK(at<std::uint64_t>(file, rec.content + 26) == 1000);
      CHECK(at<std::uint64_t>(file, rec.content + 34) == 1009);
    }
    if (rec.op == 0x0E) {
      CHECK(rec.position >= offsets);
      CHECK(file[at<std::uint64_t>(file, rec.content + 1)] == file[rec.content]);
    }
    if (rec.op == 0x06) {
      // Begin, end, size, checksum, "" and its length, size again, then the records.
      const auto chunk = file.subspan(rec.content + 40, rec.bytes - 40);
      CHECK(at<std::uint64_t>(file, rec.content + 16) == chunk.size());
      CHECK(at<std::uint32_t>(file, rec.content + 24) == crc(chunk));
    }
    if (rec.op == 0x08) CHECK(file[at<std::uint64_t>(file, rec.content + 16)] == 0x06);
  }
}

TEST_CASE("layouts: what an MCAP file was given is read again, of ROS1 and ROS2") {
  const TemporaryFolder folder;
  for (const io::Encoding encoding : {io::Encoding::ros1, io::Encoding::cdr}) {
    for (const auto compression :
         {io::mcap::Compression::none, io::mcap::Compression::lz4, io::mcap::Compression::zstd}) {
      small_file(folder, encoding, compression);
      const auto reader = io::open_messages(folder / "small.mcap");
      REQUIRE(reader->connections().size() == 2);
      const io::Connection expected = channel("/a", encoding), got = reader->connections().front();
      CHECK(got.topic == expected.topic);
      CHECK(got.type == expected.type);
      CHECK(got.md5 == expected.md5);
      CHECK(got.definition == expected.definition);
      CHECK(got.encoding == encoding);
      io::RawMessage message;
      for (std::uint8_t i = 0; i < 10; ++i) {
        REQUIRE(reader->next(message));
        CHECK(message.time == 1000 + i);
        CHECK(std::vector<std::uint8_t>(message.bytes.begin(), message.bytes.end()) ==
              std::vector<std::uint8_t>(40, i));
      }
      CHECK_FALSE(reader->next(message));
      CHECK(reader->warnings().empty());
    }
  }
}

TEST_CASE("layouts: an MCAP file without messages is one") {
  const TemporaryFolder folder;
  io::mcap::McapWriter(folder / "empty.mcap").close();
  const auto reader = io::open_messages(folder / "empty.mcap");
  io::RawMessage message;
  CHECK_FALSE(reader->next(message));
  CHECK(reader->warnings().empty());
}

TEST_CASE("layouts: an MCAP writer refuses what no file can hold") {
  const TemporaryFolder folder;
  io::mcap::McapWriter writer(folder / "refused.mcap");
  CHECK_THROWS_AS(writer.add(channel("/a", io::Encoding::other)), DataError);
  CHECK_THROWS_WITH(writer.write(3, 0, {}), Contains("there is no such channel"));
  const auto id = writer.add(channel("/a", io::Encoding::cdr));
  CHECK_THROWS_WITH(writer.write(id, -1, {}), Contains("refused.mcap") && Contains("times begin at 0"));
}
