#pragma once
/// Records of an MCAP file: where they lie, and the fields of those that a reader needs.

#include <array>
#include <bit>
#include <concepts>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "../input_file.hpp"
#include "aslio/core/time.hpp"

namespace aslio::io::mcap {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian and read with memcpy");

inline constexpr std::string_view kMagic = "\x89MCAP0\r\n";
inline constexpr std::uint64_t kHeadBytes = 9;         ///< of a record: kind and length
inline constexpr std::uint64_t kFooterBytes = 20;      ///< content of the footer
inline constexpr std::uint64_t kMessageFields = 22;    ///< of a message record, in front of the message
inline constexpr std::uint8_t kFirstForeignOp = 0x10;  ///< kinds from here on are none of this version

enum class Op : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F
};

using Bytes = std::span<const std::uint8_t>;

struct Record {
  Op op{};
  std::uint64_t position = 0, data_begin = 0, data_bytes = 0;
  std::uint64_t next() const { return data_begin + data_bytes; }
};

enum class Parsed : std::uint8_t {
  ok,
  data_cut,  ///< its content reaches beyond the end: next() must not be used
  head_cut,  ///< not even kind and length are whole
  no_record  ///< a kind that cannot be
};

/// Reads kind and length of the record at `position` of a region that ends at `end`.
Parsed parse_record(ByteView& view, std::uint64_t position, std::uint64_t end, Record& record);

/// Fields of a record in their order. Behind the end of the record they are empty or 0 and `whole()` is false; fields
/// that are left over are those of later versions.
class Fields {
 public:
  explicit Fields(Bytes bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const Bytes from = bytes(sizeof(T));
    T value = 0;
    if (!from.empty()) std::memcpy(&value, from.data(), sizeof(T));
    return value;
  }
  Bytes bytes(std::uint64_t count);
  /// With a 32-bit length in front: strings, arrays, maps.
  Bytes sized() { return bytes(number<std::uint32_t>()); }
  std::string text();
  /// A time of 2^63 ns and more cannot be told: then whole() is false.
  TimeNs time();

  bool whole() const { return whole_; }
  bool empty() const { return rest_.empty(); }

 private:
  Bytes rest_;
  bool whole_ = true;
};

struct Schema {
  std::uint16_t id = 0;
  std::string name, encoding, data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::uint16_t id = 0, schema = 0;  ///< schema 0: none
  std::string topic, encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const Channel&) const = default;
};

struct ChunkHead {
  TimeNs begin = 0, end = 0;  ///< of its messages; both 0 where there is none
  std::uint64_t declared = 0;
  std::uint32_t crc = 0;
  std::string compression;
  std::uint64_t data_begin = 0, data_bytes = 0;  ///< its records, as they lie in the file
};

struct ChunkIndex {
  TimeNs begin = 0, end = 0;
  std::uint64_t position = 0, bytes = 0,
                index_bytes = 0;        ///< of the chunk record, and of the message indexes behind it
  std::vector<std::uint32_t> channels;  ///< sorted
};

struct Footer {
  std::uint64_t summary_begin = 0;  ///< 0: none
  std::uint32_t summary_crc = 0;
};

// Each returns nullopt where the content is shorter than its fields.
std::optional<Schema> parse_schema(Bytes content);
std::optional<Channel> parse_channel(Bytes content);
std::optional<ChunkIndex> parse_chunk_index(Bytes content);
std::optional<Footer> parse_footer(Bytes content);
/// From the record itself, as a chunk is too long to be held. Its data may reach beyond the end of a file that is cut.
std::optional<ChunkHead> parse_chunk_head(ByteView& view, const Record& record);

/// Fields in front of a message.
struct MessageHead {
  std::uint16_t channel = 0;
  std::optional<TimeNs> time;  ///< nullopt: 2^63 ns and more
};
/// Pre: kMessageFields bytes.
MessageHead parse_message_head(const std::uint8_t* from);

}  // namespace aslio::io::mcap
