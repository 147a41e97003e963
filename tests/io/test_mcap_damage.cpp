#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <random>

#include "aslio/core/errors.hpp"
#include "io/mcap_fixture.hpp"
#include "mcap/reader.hpp"

namespace aslio::io::test {
namespace {

const std::vector<std::string> kCompressions{"", "lz4", "zstd"};

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

/// All that is read must be of the file, in any order, each once.
bool part_of(std::vector<Read> read, std::vector<Read> whole) {
  const auto less = [](const Read& a, const Read& b) {
    return std::tie(a.time, a.connection, a.bytes) < std::tie(b.time, b.connection, b.bytes);
  };
  std::sort(read.begin(), read.end(), less);
  std::sort(whole.begin(), whole.end(), less);
  return std::includes(whole.begin(), whole.end(), read.begin(), read.end(), less);
}

struct Sample {
  TemporaryFolder folder;
  ByteVector bytes;
  std::vector<Read> messages;

  explicit Sample(const McapOptions& options, int count = 20) : bytes(small_mcap(options, count)) {
    const ReadFile whole = read(bytes);
    REQUIRE(whole.refusal.empty());
    REQUIRE(whole.messages.size() == static_cast<std::size_t>(count));
    messages = whole.messages;
  }
  ReadFile read(const ByteVector& damaged) const {
    write_bytes(folder / "damaged.mcap", damaged);
    ReadFile file = read_mcap(folder / "damaged.mcap");
    if (!file.refusal.empty()) REQUIRE(contains(file.refusal, "damaged.mcap: "));
    return file;
  }
  ReadFile read_flipped(std::size_t byte, int bit) const {
    ByteVector damaged = bytes;
    damaged[byte] = static_cast<std::uint8_t>(damaged[byte] ^ (1U << bit));
    return read(damaged);
  }
};

McapOptions small_chunks(const std::string& compression) {
  McapOptions options{compression};
  options.chunk_bytes = 250;
  return options;
}

std::uint64_t load_number(const ByteVector& bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void store(ByteVector& bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Positions of the records of a kind outside chunks.
std::vector<std::size_t> records(const ByteVector& bytes, std::uint8_t op) {
  std::vector<std::size_t> found;
  for (std::size_t at = 8; at + 9 <= bytes.size() && bytes[at] != 0x89;
       at += 9 + static_cast<std::size_t>(load_number(bytes, at + 1))) {
    if (bytes[at] == op) found.push_back(at);
  }
  return found;
}

/// Where the summary begins.
std::size_t summary_of(const ByteVector& bytes) {
  return static_cast<std::size_t>(load_number(bytes, bytes.size() - 8 - 20));
}

// Places in a chunk record.
constexpr std::size_t kBegin = 9, kEnd = 17, kDeclared = 25, kCrc = 33;

}  // namespace

TEST_CASE("an MCAP file cut at any byte yields its whole messages and says that it is cut") {
  McapOptions options = small_chunks(GENERATE(from_range(kCompressions)));
  options.chunks = GENERATE(true, false);
  options.message_indexes = GENERATE(true, false);
  const Sample sample(options);
  std::size_t last = 0;
  bool prefix = true, monotone = true, said = true, refused_late = false;
  for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
    const ReadFile cut = sample.read({sample.bytes.begin(), sample.bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    refused_late = refused_late || (!cut.refusal.empty() && size >= 8 + 9 + 12);
    if (!cut.refusal.empty()) continue;
    prefix = prefix && std::equal(cut.messages.begin(), cut.messages.end(), sample.messages.begin());
    monotone = monotone && cut.messages.size() >= last;
    said = said && cut.status == InputStatus::truncated && contains(cut.warnings, "cut short");
    last = cut.messages.size();
  }
  CHECK(prefix);
  CHECK(monotone);
  CHECK(said);
  CHECK_FALSE(refused_late);
  CHECK(last == sample.messages.size());
}

TEST_CASE("a chunk of an MCAP file that is cut yields what can be decompressed of it") {
  McapOptions options{GENERATE(as<std::string>{}, "", "zstd")};
  options.chunk_bytes = 10U << 20U;
  McapWriter writer(options);
  const std::uint16_t a = writer.add_channel("/a", 0, "json");
  std::mt19937 random(3);
  for (TimeNs t = 0; t < 1000; ++t) {
    ByteVector bytes(1000);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    writer.write(a, t, bytes);
  }
  ByteVector bytes = writer.close();
  bytes.resize(bytes.size() / 2);
  TemporaryFolder folder;
  write_bytes(folder / "a.mcap", bytes);
  const ReadFile file = read_mcap(folder / "a.mcap");
  CHECK(file.refusal.empty());
  CHECK(file.messages.size() > 300);
  CHECK(file.messages.size() < 520);
  CHECK(file.status == InputStatus::truncated);
}

TEST_CASE("an MCAP file whose end was lost to zeros is one that is cut") {
  const Sample sample(small_chunks("zstd"));
  ByteVector bytes = sample.bytes;
  bytes.resize(records(bytes, 0x06)[2]);
  bytes.resize(bytes.size() + 5000, 0);
  const ReadFile file = sample.read(bytes);
  CHECK(file.refusal.empty());
  CHECK(file.status == InputStatus::truncated);
  CHECK(file.messages.size() > 5);
  bytes.back() = 1;
  CHECK(contains(sample.read(bytes).refusal, "damaged record at offset"));
}

TEST_CASE("flipped bits never crash the reader of MCAP files, fill the memory or yield wrong bytes") {
  McapOptions options = small_chunks(GENERATE(from_range(kCompressions)));
  options.chunks = GENERATE(true, false);
  options.summary = GENERATE(true, false);
  const Sample sample(options);
  std::mt19937 random(7);
  forget_peak();
  const std::size_t before = peak_memory();
  std::size_t refused = 0, wrong = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    ByteVector damaged = sample.bytes;
    const int flips = 1 + trial % 4;
    for (int flip = 0; flip < flips; ++flip) {
      const std::size_t at = random() % damaged.size();
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1U << (random() % 8)));
    }
    const ReadFile file = sample.read(damaged);
    refused += file.refusal.empty() ? 0 : 1;
    // Outside chunks, a second flip may take away the one checksum that there is.
    if (options.chunks || flips == 1) wrong += part_of(file.messages, sample.messages) ? 0 : 1;
  }
  CHECK(refused > 100);
  CHECK(refused < 2000);
  CHECK(wrong == 0);
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("flipped bits in an MCAP file without checksums are survived") {
  McapOptions options = small_chunks(GENERATE(from_range(kCompressions)));
  options.chunks = GENERATE(true, false);
  options.crc = false;
  const Sample sample(options);
  std::mt19937 random(11);
  forget_peak();
  const std::size_t before = peak_memory();
  for (int trial = 0; trial < 3000; ++trial) {
    ByteVector damaged = sample.bytes;
    const std::size_t at = random() % damaged.size();
    damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1U << (random() % 8)));
    sample.read(damaged);
  }
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("giant lengths anywhere in an MCAP file are survived in bounded memory") {
  McapOptions options = small_chunks(GENERATE(from_range(kCompressions)));
  options.summary = GENERATE(true, false);
  const std::size_t count = GENERATE(std::size_t{4}, std::size_t{8});
  options.crc = count == 4;
  const Sample sample(options);
  forget_peak();
  const std::size_t before = peak_memory();
  std::size_t refused = 0;
  for (std::size_t at = 8; at + count <= sample.bytes.size(); ++at) {
    ByteVector damaged = sample.bytes;
    std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(at), count, std::uint8_t{0xFF});
    refused += sample.read(damaged).refusal.empty() ? 0 : 1;
  }
  CHECK(refused > 100);
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("a chunk of an MCAP file that lies about its size is refused") {
  const std::string compression = GENERATE(as<std::string>{}, "lz4", "zstd");
  const Sample sample(small_chunks(compression));
  ByteVector bytes = sample.bytes;
  const std::size_t chunk = records(bytes, 0x06)[1];
  const std::uint64_t size = load_number(bytes, chunk + kDeclared);
  const auto declare = [&](std::uint64_t declared) {
    store(bytes, chunk + kDeclared, declared);
    return sample.read(bytes).refusal;
  };
  const std::string where = fmt::format("damaged chunk at offset {}", chunk);
  forget_peak();
  const std::size_t before = peak_memory();
  CHECK(contains(declare(60'000'000), where));  // no more than is decompressed takes memory
  CHECK(contains(declare(900'000'000), "at most 65536 times as many"));
  CHECK(contains(declare(2'000'000'000), "the limit of this reader is 1073741824"));
  CHECK(contains(declare(~std::uint64_t{0}), "the limit of this reader is 1073741824"));
  CHECK(contains(declare(size - 1), where));
  CHECK(contains(declare(size - 1), fmt::format("more than the {} bytes declared", size - 1)));
  CHECK(contains(declare(size + 1), fmt::format("{} bytes, {} declared", size, size + 1)));
  CHECK(contains(declare(0), where));
  CHECK(peak_memory() < before + kRoom);
}

TEST_CASE("a wrong checksum in an MCAP file is damage, at its place") {
  McapOptions options = small_chunks(GENERATE(from_range(kCompressions)));
  const Sample sample(options);
  const std::size_t chunk = records(sample.bytes, 0x06)[1];
  const ReadFile file = sample.read_flipped(chunk + kCrc, 3);
  CHECK(contains(file.refusal, fmt::format("damaged chunk at offset {}: its checksum is", chunk)));
  CHECK(contains(file.refusal, "mcap recover"));
  CHECK(file.messages.size() > 3);
  // That of the data section, which holds for what is outside chunks as well.
  const std::size_t end = records(sample.bytes, 0x0F)[0];
  CHECK(
      contains(sample.read_flipped(end + 9, 0).refusal, fmt::format("damaged data section, from offset 0 to {}", end)));
  CHECK(contains(sample.read_flipped(18, 0).refusal, "damaged data section"));  // name of the library
}

TEST_CASE("a message outside chunks is checked before it is handed out") {
  McapOptions options;
  options.chunks = false;
  options.summary = GENERATE(true, false);
  const Sample sample(options);
  const std::size_t last = records(sample.bytes, 0x05).back();
  const ReadFile file = sample.read_flipped(last + 9 + 22, 5);
  CHECK(file.messages.empty());
  CHECK(contains(file.refusal, "damaged data section"));
  McapOptions unprotected = small_chunks("zstd");
  ByteVector bytes = small_mcap(unprotected);
  for (const std::size_t chunk : records(bytes, 0x06))
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(chunk + kCrc), 4, std::uint8_t{0});
  // Chunks without a checksum of their own are covered by that of the data section, which is now wrong.
  CHECK(sample.read(bytes).messages.empty());
  CHECK(contains(sample.read(bytes).refusal, "damaged data section"));
}

TEST_CASE("a flipped bit in the summary of an MCAP file costs no message and no order, and is told") {
  McapOptions options = small_chunks("lz4");
  options.message_indexes = GENERATE(true, false);
  const Sample sample(options);
  std::size_t silent = 0, wrong = 0;
  const std::size_t behind = sample.bytes.size() - 8 - 4;
  for (std::size_t byte = summary_of(sample.bytes); byte < behind; ++byte) {
    // The head and first field of the footer tell whether there is a summary.
    if (byte >= behind - 25 && byte < behind - 8) continue;
    const ReadFile file = sample.read_flipped(byte, static_cast<int>(byte % 8));
    wrong += file.messages == sample.messages && file.refusal.empty() ? 0 : 1;
    silent += contains(file.warnings, "the index is damaged (") ? 0 : 1;
  }
  CHECK(wrong == 0);
  CHECK(silent == 0);
}

TEST_CASE("a flipped bit in a summary without checksum costs no message") {
  McapOptions options = small_chunks(GENERATE(as<std::string>{}, "", "zstd"));
  options.crc = false;
  const Sample sample(options);
  std::size_t lost = 0, unordered = 0;
  for (std::size_t byte = summary_of(sample.bytes); byte < sample.bytes.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      const ReadFile file = sample.read_flipped(byte, bit);
      INFO(fmt::format("byte {} bit {}: {}", byte, bit, file.refusal));
      // A description may be the one that is damaged: then the two differ.
      const bool told = contains(file.refusal, "described twice") || contains(file.refusal, "does not exist");
      lost += file.messages.size() == sample.messages.size() || told ? 0 : 1;
      unordered += file.messages == sample.messages || told ? 0 : 1;
    }
  }
  CHECK(lost == 0);
  CHECK(unordered == 0);
}

TEST_CASE("what a chunk index says wrongly of a chunk costs no message") {
  McapOptions options = small_chunks("zstd");
  options.crc = false;
  const Sample sample(options);
  const std::vector<std::size_t> indexes = records(sample.bytes, 0x08);
  REQUIRE(indexes.size() >= 4);
  const auto with = [&](std::size_t at, std::uint64_t value) {
    ByteVector bytes = sample.bytes;
    store(bytes, at, value);
    return bytes;
  };
  const auto costs_nothing = [&](const ByteVector& bytes) {
    const ReadFile file = sample.read(bytes);
    CHECK(file.messages == sample.messages);
    CHECK(contains(file.warnings, "the index is damaged ("));
  };
  const std::size_t second = indexes[1];
  costs_nothing(with(second + kBegin, 0));
  costs_nothing(with(second + kEnd, 1'000'000));
  costs_nothing(with(second + 25, load_number(sample.bytes, second + 25) + 1));
  costs_nothing(with(second + 33, 1U << 20U));
  costs_nothing(with(second + 33, ~std::uint64_t{0}));
  costs_nothing(with(indexes.back() + 33, 9));
  // A channel that the index leaves out of a chunk: found as another channel of it is read, or by the statistics.
  ByteVector bytes = sample.bytes;
  bytes[second + 45] ^= 1U;
  write_bytes(sample.folder / "a.mcap", bytes);
  for (const std::uint32_t id : {0U, 1U}) {
    mcap::McapReader reader(sample.folder / "a.mcap");
    reader.select({&id, 1});
    CHECK(read_messages(reader).size() == 10);
  }
}

TEST_CASE("an MCAP file that goes on behind its end says so") {
  const Sample sample(small_chunks("lz4"));
  ByteVector bytes = sample.bytes;
  SECTION("with another one") { bytes.insert(bytes.end(), sample.bytes.begin(), sample.bytes.end()); }
  SECTION("with something") { bytes.insert(bytes.end(), 100, 0xAB); }
  const ReadFile file = sample.read(bytes);
  CHECK(file.messages == sample.messages);
  CHECK(contains(file.warnings, fmt::format("behind the end of the recording, at offset {}", sample.bytes.size())));
}

TEST_CASE("limits of the reader of MCAP files can be set") {
  TemporaryFolder folder;
  McapOptions options;
  options.chunks = GENERATE(true, false);
  write_bytes(folder / "a.mcap", small_mcap(options));
  mcap::Limits limits;
  std::string part = "the limit of this reader";
  SECTION("message") { limits.message_bytes = 5; }
  SECTION("descriptions") { limits.description_bytes = 300; }
  SECTION("record") {
    limits.record_bytes = 10;
    part = "at most 10";
  }
  RawMessage message;
  const std::string error = data_error([&] {
    mcap::McapReader reader(folder / "a.mcap", limits);
    while (reader.next(message)) {
    }
  });
  CHECK(contains(error, part));
}

TEST_CASE("an unknown compression is named with a remedy") {
  const Sample sample(small_chunks("zstd"));
  ByteVector bytes = sample.bytes;
  bytes[records(bytes, 0x06)[0] + 9 + 32] = 'Z';
  CHECK(contains(sample.read(bytes).refusal, "has the compression 'Zstd' (none, lz4 and zstd are known)"));
}

}  // namespace aslio::io::test
