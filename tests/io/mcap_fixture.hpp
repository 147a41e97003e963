#pragma once
/// Small MCAP files made to measure, and what a reader makes of them.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "aslio/io/message_reader.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {

using ByteVector = std::vector<std::uint8_t>;

/// A record of any kind.
void append_record(ByteVector& out, std::uint8_t op, const ByteVector& content);

/// Fields of a record, packed.
class Packed {
 public:
  template <class T>
  Packed& number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  Packed& text(std::string_view value);
  Packed& raw(const ByteVector& value);
  Packed& map(const std::map<std::string, std::string>& value);
  const ByteVector& bytes() const { return bytes_; }

 private:
  ByteVector bytes_;
};

struct McapOptions {
  std::string compression;         ///< "", "lz4" or "zstd"
  bool chunks = true;              ///< false: messages outside chunks
  bool summary = true;             ///< with copies of schemas and channels, chunk indexes and statistics
  bool message_indexes = true;     ///< behind each chunk
  bool crc = true;                 ///< all checksums
  std::size_t chunk_bytes = 4096;  ///< a chunk ends once it is as long
};

class McapWriter {
 public:
  explicit McapWriter(McapOptions options = {});

  std::uint16_t add_schema(const std::string& name, const std::string& encoding, const std::string& data);
  /// `schema` 0: none. Goes where the next message goes.
  std::uint16_t add_channel(const std::string& topic, std::uint16_t schema, const std::string& encoding,
                            const std::map<std::string, std::string>& metadata = {});
  void write(std::uint16_t channel, TimeNs time, const ByteVector& bytes);
  /// Ends the chunk that is open.
  void end_chunk();
  /// As it is, behind the chunks so far.
  void add_record(std::uint8_t op, const ByteVector& content);
  /// Into the chunk that is open.
  void add_to_chunk(std::uint8_t op, const ByteVector& content) { append_record(chunk_, op, content); }
  /// A message outside chunks, whatever the options.
  void write_outside(std::uint16_t channel, TimeNs time, const ByteVector& bytes);
  /// The whole file.
  const ByteVector& close();
  /// Of what is written so far.
  std::size_t size() const { return file_.size(); }

 private:
  ByteVector& place() { return options_.chunks ? chunk_ : file_; }
  /// Returns the map of channels and places that a chunk index holds.
  ByteVector add_message_indexes();
  void add_summary();
  void count(std::uint16_t channel, TimeNs time);

  McapOptions options_;
  ByteVector file_, chunk_, schemas_, channels_, chunk_indexes_;
  std::uint16_t next_schema_ = 1, next_channel_ = 0;
  std::map<std::uint16_t, std::vector<std::pair<TimeNs, std::uint64_t>>> entries_;  ///< of the open chunk
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint32_t chunk_count_ = 0;
  TimeNs begin_ = kTimeMax, end_ = kTimeMin;
};

/// Two channels (0: /a, of md5 "5a"; 1: /b) of alternating messages, each with bytes of its own;
/// `count` in all, times 10 ns apart, from 1000 on.
ByteVector small_mcap(const McapOptions& options, int count = 20);

/// A message that was read.
struct Read {
  std::uint32_t connection = 0;
  TimeNs time = 0;
  ByteVector bytes;
  bool operator==(const Read&) const = default;
};

struct ReadFile {
  std::vector<Read> messages;
  InputStatus status = InputStatus::complete;
  std::vector<std::string> warnings;
  std::string refusal;  ///< text of the DataError
};
/// Reads until the end or a DataError.
ReadFile read_mcap(const std::filesystem::path& path);

std::vector<Read> read_messages(MessageReader& reader);

}  // namespace aslio::io::test
