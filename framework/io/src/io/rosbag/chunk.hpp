#pragma once
/// Chunks: where their messages lie, and their bytes.

#include <string>
#include <vector>

#include "../chunk_player.hpp"
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

struct BagIndex {
  ConnectionTable connections;
  std::vector<ChunkInfo> chunks;  ///< in the order of sort_chunks()
  InputStatus status = InputStatus::complete;
  std::vector<std::string> warnings;
  bool scanned = false;  ///< from the records themselves
};

BagIndex read_bag_index(const InputFile& file, const Limits& limits);

/// The index by the records of a bag whose own is not to be believed: `why`, for a warning.
BagIndex scan_damaged_index(const InputFile& file, const Limits& limits, const std::string& why);

}  // namespace aslio::io::rosbag
