#pragma once
/// Chunks: where their messages lie, and their bytes.

#include <string>
#include <vector>

#include "../input_file.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "record.hpp"

namespace aslio::io::rosbag {

/// Connections by id, ascending.
class ConnectionTable {
 public:
  /// Returns what is wrong: too many, or a second description of an id that differs from the first.
  std::string add(Connection connection, std::size_t limit);
  bool contains(std::uint32_t id) const;
  const std::vector<Connection>& all() const { return all_; }

 private:
  std::vector<Connection> all_;
};

struct MessageEntry {
  TimeNs time = 0;
  std::uint64_t offset = 0;  ///< into the memory of the chunk, or into the file
  std::uint32_t bytes = 0, connection = 0;
};

struct LoadedChunk {
  std::vector<MessageEntry> entries;  ///< by time, equal times in file order
  std::vector<std::uint8_t> memory;   ///< decompressed bytes; empty for an uncompressed chunk
  bool in_memory = false;
  bool cut = false;  ///< the file ends inside it
  // Of all its messages, also those that are not wanted.
  std::uint64_t messages = 0;
  TimeNs begin = kTimeMax, end = kTimeMin;
};

class ChunkLoader {
 public:
  ChunkLoader(const InputFile& file, const Limits& limits) : file_(file), limits_(limits), view_(file) {}

  /// Lists the messages of the chunk record at `position` whose connection is in `wanted` (sorted; null: all).
  /// A message of a connection not in `known` is damage. With `learn`, connection records are added to `known`.
  /// Throws DataError for damage, and for a cut unless `may_be_cut`.
  void load(std::uint64_t position, bool may_be_cut, const std::vector<std::uint32_t>* wanted, ConnectionTable& known,
            bool learn, LoadedChunk& out);

 private:
  [[noreturn]] void damaged(std::uint64_t position, const std::string& why) const;
  void decompress_into(std::uint64_t position, const Record& chunk, bool may_be_cut, LoadedChunk& out);
  std::string list(ByteView& view, std::uint64_t begin, std::uint64_t end, const std::vector<std::uint32_t>* wanted,
                   ConnectionTable& known, bool learn, LoadedChunk& out);

  const InputFile& file_;
  const Limits& limits_;
  ByteView view_;
  std::vector<std::uint8_t> compressed_;
};

/// What a bag says about its chunks, from its index or from a scan.
struct ChunkInfo {
  std::uint64_t position = 0;
  TimeNs begin = 0, end = 0;
  std::vector<std::uint32_t> connections;  ///< ids with messages in it, sorted
  std::uint64_t messages = 0;              ///< from an index
};

struct BagIndex {
  ConnectionTable connections;
  std::vector<ChunkInfo> chunks;  ///< by begin, then position
  InputStatus status = InputStatus::complete;
  std::vector<std::string> warnings;
  bool scanned = false;  ///< from the records themselves
};

BagIndex read_bag_index(const InputFile& file, const Limits& limits);

/// The index by the records of a bag whose own is not to be believed: `why`, for a warning.
BagIndex scan_damaged_index(const InputFile& file, const Limits& limits, const std::string& why);

}  // namespace aslio::io::rosbag
