#pragma once
/// Chunks, and runs of messages outside chunks: where their messages lie, and their bytes.

#include <bitset>

#include "../chunk_player.hpp"
#include "channels.hpp"
#include "checksum.hpp"

namespace aslio::io::mcap {

/// What to do about a file that is damaged.
inline constexpr std::string_view kRemedy =
    "copy the file again from its origin, or take out what is whole with `mcap recover`";

class ChunkLoader {
 public:
  ChunkLoader(const InputFile& file, const Limits& limits) : file_(file), limits_(limits), view_(file) {}

  struct Task {
    const std::vector<std::uint32_t>* wanted = nullptr;  ///< sorted channels; null: all
    bool may_be_cut = false;                             ///< the file may end inside it
    bool learn = false;                                  ///< add the channels and schemas in it to the table
    DataChecksum* checksum = nullptr;                    ///< to check what has no checksum of its own
  };
  /// Lists the messages of the chunk or run `info`. A message of a channel that is not in `table` is damage, and so is
  /// a description that differs from it. Throws DataError.
  void load(const ChunkInfo& info, const Task& task, ChannelTable& table, LoadedChunk& out);

 private:
  struct Region;
  [[noreturn]] void damaged(std::uint64_t position, const std::string& why) const;
  void load_chunk(const ChunkInfo& info, const Task& task, ChannelTable& table, LoadedChunk& out);
  void check_sizes(std::uint64_t position, const ChunkHead& head) const;
  void decompress_into(std::uint64_t position, const ChunkHead& head, const Task& task, LoadedChunk& out);
  void check_stored(std::uint64_t position, const ChunkHead& head, const Task& task);
  void compare_crc(std::uint64_t position, const ChunkHead& head, std::uint32_t found) const;
  std::string list(const Region& region, const Task& task, ChannelTable& table, LoadedChunk& out);
  std::string describe(ByteView& view, const Record& record, const Task& task, ChannelTable& table) const;
  std::string add_message(ByteView& view, const Record& record, const Task& task, const ChannelTable& table,
                          LoadedChunk& out);

  const InputFile& file_;
  const Limits& limits_;
  ByteView view_;
  ByteBuffer compressed_;
  std::bitset<1U << 16U> seen_;  ///< channels of the region that is listed
};

/// Reads the schema or channel in `record` into the table. Returns what is wrong.
std::string learn_description(ByteView& view, const Record& record, const Limits& limits, ChannelTable& table);

/// Refuses a message that is too long. Throws DataError.
void check_message_length(const InputFile& file, const Record& record, const Limits& limits);

}  // namespace aslio::io::mcap
