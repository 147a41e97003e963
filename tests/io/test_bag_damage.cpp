#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <random>
#include <string>

#include "aslio/core/errors.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

struct Outcome {
  bool refused = false;
  std::size_t messages = 0;
  InputStatus status = InputStatus::complete;
};

/// Reads everything; a refusal must name the file.
Outcome read_all(const std::filesystem::path& path) {
  Outcome outcome;
  try {
    rosbag::BagReader reader(path);
    rosbag::BagMessage message;
    while (reader.next(message)) ++outcome.messages;
    outcome.status = reader.status();
  } catch (const DataError& error) {
    outcome.refused = true;
    REQUIRE(contains(error.what(), path.filename().string()));
  }
  return outcome;
}

Recording small(rosbag::Compression compression, bool index) {
  Recording recording;
  recording.seconds = 0.15;
  recording.points = 3;
  recording.options = {compression, 1500, index};
  return recording;
}

/// Largest resident memory since forget_peak() [bytes].
std::size_t peak_memory() {
  std::ifstream file("/proc/self/status");
  std::string word;
  while (file >> word && word != "VmHWM:") {
  }
  std::size_t kilobytes = 0;
  file >> kilobytes;
  return kilobytes * 1024;
}

void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kRoom = 512U << 20U;  // freed memory stays in quarantine
#else
constexpr std::size_t kRoom = 64U << 20U;
#endif

struct Sequence {
  std::vector<std::pair<std::uint32_t, TimeNs>> messages;  ///< connection and time
  bool warned = false;                                     ///< of the index
};

Sequence sequence_of(const std::filesystem::path& path) {
  Sequence sequence;
  rosbag::BagReader reader(path);
  rosbag::BagMessage message;
  while (reader.next(message)) sequence.messages.emplace_back(message.connection, message.time);
  sequence.warned = contains(reader.warnings(), "the index is damaged (");
  return sequence;
}

/// Where the values of a field of chunk infos stand.
std::vector<std::size_t> places(const std::vector<std::uint8_t>& bytes, const std::string& key) {
  std::vector<std::size_t> found;
  for (auto at = bytes.begin();; ++at) {
    at = std::search(at, bytes.end(), key.begin(), key.end());
    if (at == bytes.end()) return found;
    found.push_back(static_cast<std::size_t>(at - bytes.begin()) + key.size());
  }
}

void replace(std::vector<std::uint8_t>& bytes, std::size_t from, const std::string& key, std::uint32_t value) {
  const auto at = std::search(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.end(), key.begin(), key.end());
  REQUIRE(at != bytes.end());
  for (std::size_t i = 0; i < 4; ++i) {
    *(at + static_cast<std::ptrdiff_t>(key.size() + i)) = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

}  // namespace

TEST_CASE("a bag cut at any byte yields its whole messages and says that it is cut") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  small(compression, true).write(folder / "whole.bag");
  const auto bytes = read_bytes(folder / "whole.bag");
  const std::size_t all = read_all(folder / "whole.bag").messages;
  REQUIRE(all == 17);
  std::size_t last = 0;
  bool monotone = true, said = true, refused_late = false;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    write_bytes(folder / "cut.bag", {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    const Outcome outcome = read_all(folder / "cut.bag");
    refused_late = refused_late || (outcome.refused && size >= 4096 + 13);
    if (outcome.refused) continue;
    monotone = monotone && outcome.messages >= last;
    said = said && outcome.status == InputStatus::truncated;
    last = outcome.messages;
  }
  CHECK(monotone);
  CHECK(said);
  CHECK_FALSE(refused_late);
  CHECK(last == all);
}

TEST_CASE("a truncated bag still plays as a source") {
  TemporaryFolder folder;
  Recording{}.write(folder / "a.bag");
  std::filesystem::resize_file(folder / "a.bag", std::filesystem::file_size(folder / "a.bag") * 6 / 10);
  const auto source = open_source(folder / "a.bag", {});
  const Counts counts = drain(*source);
  CHECK(counts.imu > 100);
  CHECK(counts.imu < 150);
  CHECK(source->status() == InputStatus::truncated);
  CHECK(contains(source->notes().warnings, "cut short"));

  // What was cut off is nothing that this section lacks.
  const auto section = open_source(folder / "a.bag", {}, {.start = 0.1, .duration = 0.4});
  CHECK(drain(*section).imu == 40);
  CHECK(section->status() == InputStatus::complete);
}

TEST_CASE("a bag cut inside its first chunk is refused for that, not for a topic that it lacks") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  Recording recording = small(compression, true);
  recording.options.chunk_bytes = 1U << 20U;
  recording.write(folder / "whole.bag");
  const auto bytes = read_bytes(folder / "whole.bag");
  constexpr std::size_t kFirstRecord = 4096 + 13;
  SensorConfig sensor;
  sensor.lidar_topic = recording.lidar_topic;
  const auto cut_at = [&](std::size_t size) {
    write_bytes(folder / "cut.bag", {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    return data_error([&] { open_source(folder / "cut.bag", sensor); });
  };
  std::size_t played = 0;
  for (std::size_t size = kFirstRecord; size <= bytes.size(); size += 7) {
    const std::string error = cut_at(size);
    played += error.empty() ? 1 : 0;
    if (error.empty()) continue;
    INFO(error);
    REQUIRE(contains(error, fmt::format("cut.bag: the file is cut short at {} bytes, before", size)) !=
            contains(error, fmt::format("; the file is cut short at {} bytes: ", size)));
    REQUIRE(contains(error, "copy it again from its origin"));
  }
  CHECK(played > 0);
  for (const std::size_t size : {kFirstRecord, kFirstRecord + 30, kFirstRecord + 300}) {
    const std::string error = cut_at(size);
    CHECK(contains(error, "before its first whole message; copy it again from its origin"));
    CHECK_FALSE(contains(error, "(none)"));
    const InputReport report = inspect(folder / "cut.bag", sensor);
    CHECK(report.status == InputStatus::truncated);
    CHECK(report.reason == error);
  }
}

TEST_CASE("flipped bits never crash the reader nor fill the memory") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  const bool index = GENERATE(true, false);
  TemporaryFolder folder;
  small(compression, index).write(folder / "whole.bag");
  const auto bytes = read_bytes(folder / "whole.bag");
  std::mt19937 random(7);
  forget_peak();
  const std::size_t before = peak_memory();
  std::size_t refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    auto damaged = bytes;
    for (int flip = 0; flip < 1 + trial % 4; ++flip) {
      // The padding of the header would take most of the hits.
      const bool header = random() % 8 == 0;
      const std::size_t at = header ? random() % 100 : 4100 + random() % (bytes.size() - 4100);
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1U << (random() % 8)));
    }
    write_bytes(folder / "damaged.bag", damaged);
    refused += read_all(folder / "damaged.bag").refused ? 1 : 0;
  }
  CHECK(refused > 100);
  CHECK(refused < 2000);
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("a length of 0xFFFFFFFF anywhere is survived in bounded memory") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  small(compression, true).write(folder / "whole.bag");
  const auto bytes = read_bytes(folder / "whole.bag");
  forget_peak();
  const std::size_t before = peak_memory();
  std::size_t refused = 0;
  for (std::size_t at = 13; at + 4 <= bytes.size(); at = at == 100 ? 4109 : at + 1) {
    auto damaged = bytes;
    std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(at), 4, std::uint8_t{0xFF});
    write_bytes(folder / "damaged.bag", damaged);
    refused += read_all(folder / "damaged.bag").refused ? 1 : 0;
  }
  CHECK(refused > 100);
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("a chunk that claims to decompress a thousandfold is refused before it is decompressed") {
  TemporaryFolder folder;
  Recording recording = small(rosbag::Compression::lz4, true);
  recording.write(folder / "bomb.bag");
  auto bytes = read_bytes(folder / "bomb.bag");
  SECTION("beyond the ratio") {
    replace(bytes, 4109, "size=", 20'000'000);
    write_bytes(folder / "bomb.bag", bytes);
    CHECK(contains(data_error([&] { drain(*open_source(folder / "bomb.bag", {})); }), "256 times"));
  }
  SECTION("beyond the limit of a chunk") {
    replace(bytes, 4109, "size=", 100U << 20U);
    write_bytes(folder / "bomb.bag", bytes);
    rosbag::Limits limits;
    limits.chunk_bytes = 64U << 20U;
    rosbag::BagMessage message;
    const std::string text = data_error([&] {
      rosbag::BagReader reader(folder / "bomb.bag", limits);
      while (reader.next(message)) {
      }
    });
    CHECK(contains(text, "at most 67108864 are read at once; write the bag with smaller chunks"));
  }
  SECTION("more than declared") {
    replace(bytes, 4109, "size=", 1000);
    write_bytes(folder / "bomb.bag", bytes);
    CHECK(contains(data_error([&] { drain(*open_source(folder / "bomb.bag", {})); }), "more than the 1000 bytes"));
  }
}

TEST_CASE("limits can be set") {
  TemporaryFolder folder;
  small(rosbag::Compression::none, true).write(folder / "a.bag");
  rosbag::Limits limits;
  SECTION("connections") { limits.connections = 1; }
  SECTION("header bytes") { limits.header_bytes = 60; }
  SECTION("record bytes") { limits.record_bytes = 1000; }
  rosbag::BagMessage message;
  CHECK_FALSE(data_error([&] {
                rosbag::BagReader reader(folder / "a.bag", limits);
                while (reader.next(message)) {
                }
              }).empty());
}

TEST_CASE("a damaged index costs no message") {
  TemporaryFolder folder;
  small(rosbag::Compression::none, true).write(folder / "a.bag");
  auto bytes = read_bytes(folder / "a.bag");
  const std::string key = "chunk_pos=";
  const auto at = std::find_end(bytes.begin(), bytes.end(), key.begin(), key.end());
  REQUIRE(at != bytes.end());
  *(at + 14) = 0xFF;
  write_bytes(folder / "a.bag", bytes);
  rosbag::BagReader reader(folder / "a.bag");
  rosbag::BagMessage message;
  std::size_t count = 0;
  while (reader.next(message)) ++count;
  CHECK(count == 17);
  CHECK(contains(reader.warnings(), "index is damaged"));
}

TEST_CASE("a flipped bit in what the index says of a chunk costs no message and no order, and is told") {
  const auto compression = GENERATE(rosbag::Compression::none, rosbag::Compression::lz4);
  TemporaryFolder folder;
  small(compression, true).write(folder / "a.bag");
  const auto bytes = read_bytes(folder / "a.bag");
  const Sequence whole = sequence_of(folder / "a.bag");
  REQUIRE(whole.messages.size() == 17);
  REQUIRE_FALSE(whole.warned);
  const auto flipped = [&](std::size_t byte, int bit) {
    auto damaged = bytes;
    damaged[byte] = static_cast<std::uint8_t>(damaged[byte] ^ (1U << bit));
    write_bytes(folder / "b.bag", damaged);
    return sequence_of(folder / "b.bag");
  };
  std::size_t chunks = 0, silent = 0, wrong = 0;
  for (const std::string key : {"start_time=", "end_time="}) {
    for (const std::size_t at : places(bytes, key)) {
      ++chunks;
      for (int bit = 0; bit < 64; ++bit) {
        const Sequence damaged = flipped(at + static_cast<std::size_t>(bit / 8), bit % 8);
        silent += damaged.warned ? 0 : 1;
        wrong += damaged.messages == whole.messages ? 0 : 1;
      }
    }
  }
  CHECK(chunks >= 6);
  CHECK(silent == 0);
  CHECK(wrong == 0);
  // The count field of a chunk info is its last; a length and pairs of connection and count follow it.
  const std::size_t first = places(bytes, "count=").back() + 8;
  for (std::size_t byte = first; byte < bytes.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      const Sequence damaged = flipped(byte, bit);
      wrong += damaged.messages == whole.messages ? 0 : 1;
      const bool count = (byte - first) % 8 >= 4, other_topic = byte == first && bit == 0 && bytes.size() - first == 8;
      silent += damaged.warned || (!count && other_topic) ? 0 : 1;
    }
  }
  CHECK(silent == 0);
  CHECK(wrong == 0);
}

TEST_CASE("an index that takes a chunk for a later or another one costs no message") {
  TemporaryFolder folder;
  small(rosbag::Compression::none, true).write(folder / "a.bag");
  const auto bytes = read_bytes(folder / "a.bag");
  const auto read = [&](const std::function<void(std::vector<std::uint8_t>&)>& damage) {
    auto damaged = bytes;
    damage(damaged);
    write_bytes(folder / "b.bag", damaged);
    Sequence sequence = sequence_of(folder / "b.bag");
    CHECK(sequence.warned);
    return sequence.messages.size();
  };
  const std::size_t start = places(bytes, "start_time=")[1], end = places(bytes, "end_time=")[1];
  CHECK(read([&](auto& b) { b[start] ^= 2U, b[end] ^= 2U; }) == 17);  // 2 s later
  const std::size_t pair = places(bytes, "count=").back() + 8;
  CHECK(read([&](auto& b) { b[pair] ^= 0x40U; }) == 17);  // no such connection
  // What is open when the index is found out comes once, and its topics stay selected.
  auto damaged = bytes;
  damaged[end + 4] ^= 1U;
  write_bytes(folder / "b.bag", damaged);
  rosbag::BagReader reader(folder / "b.bag");
  const std::uint32_t imu = 0;
  for (int again = 0; again < 2; ++again) {
    reader.select({&imu, 1});
    rosbag::BagMessage message;
    std::size_t count = 0;
    for (; reader.next(message); ++count) REQUIRE(message.time == kStart + static_cast<TimeNs>(count) * kSecond / 100);
    CHECK(count == 15);
  }
  CHECK(reader.warnings().size() == 1);
}

}  // namespace aslio::io::test
