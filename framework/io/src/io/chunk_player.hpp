#pragma once
/// Messages of a chunked container in the order of their time: chunks that overlap in time are merged, and only those
/// are held at once.

#include <deque>
#include <string>
#include <vector>

#include "aslio/io/message_reader.hpp"
#include "byte_buffer.hpp"
#include "input_file.hpp"

namespace aslio::io {

/// What an index or a scan tells of a chunk.
struct ChunkInfo {
  std::uint64_t position = 0;  ///< into the file
  TimeNs begin = 0, end = 0;
  std::vector<std::uint32_t> connections;  ///< ids with messages in it, sorted; empty: not known
  std::uint64_t messages = 0;              ///< 0: not known
  std::uint64_t file_end = 0;              ///< of a run of messages outside chunks, where it ends; 0: a chunk
};

/// Puts them in the order in which a player opens them.
void sort_chunks(std::vector<ChunkInfo>& chunks);

struct MessageEntry {
  TimeNs time = 0;
  std::uint64_t offset = 0;  ///< into the memory of the chunk, or into the file
  std::uint32_t bytes = 0, connection = 0;
};

struct LoadedChunk {
  std::uint64_t position = 0;
  std::vector<MessageEntry> entries;  ///< by time, equal times in file order
  std::size_t next = 0;               ///< entry that is due
  ByteBuffer memory;                  ///< decompressed bytes
  bool in_memory = false;             ///< false: its messages are read from the file
  bool cut = false;                   ///< the file ends inside it
  // Of all its messages, also those that are not wanted.
  std::uint64_t messages = 0;
  TimeNs begin = kTimeMax, end = kTimeMin;
  std::vector<std::uint32_t> connections;  ///< sorted; where the container compares them with its index

  void start_over(std::uint64_t at);
  void put_in_order();
  std::uint64_t held_bytes() const { return memory.size() + entries.size() * sizeof(MessageEntry); }
};

/// The chunks of a container.
class ChunkStore {
 public:
  virtual ~ChunkStore() = default;
  /// In the order of sort_chunks().
  virtual const std::vector<ChunkInfo>& chunks() const = 0;
  /// Whether chunks() comes from the records themselves, not from an index.
  virtual bool scanned() const = 0;
  /// Lists the messages of a chunk whose connection is in `wanted` (sorted; null: all). Throws DataError for damage.
  virtual void load(const ChunkInfo& info, const std::vector<std::uint32_t>* wanted, LoadedChunk& out) = 0;
  /// How a chunk differs from what the index says of it; empty where it does not.
  virtual std::string disagreement(const ChunkInfo& info, const LoadedChunk& chunk) const = 0;
  /// Replaces chunks() by what the records tell, as the index is not to be believed: `why`.
  virtual void rescan(const std::string& why) = 0;
  virtual void warn(const std::string& text) = 0;
};

class ChunkPlayer {
 public:
  /// `merged_bytes`: what chunks that overlap in time may hold before the order becomes approximate.
  ChunkPlayer(const InputFile& file, ChunkStore& store, std::uint64_t merged_bytes)
      : file_(file), store_(store), merged_bytes_(merged_bytes), view_(file) {}

  /// As MessageReader.
  void select(std::span<const std::uint32_t> ids);
  /// As MessageReader, without the encoding.
  bool next(RawMessage& message);
  /// Has the store scan its records, and goes on with what it finds.
  void rebuild_index(const std::string& why);

 private:
  bool more_chunks();
  bool wanted(const ChunkInfo& info) const;
  bool must_open_next();
  void open_next();
  LoadedChunk* acquire();
  void give_back(LoadedChunk* chunk);
  std::span<const std::uint8_t> bytes_of(const LoadedChunk& chunk, const MessageEntry& entry);

  const InputFile& file_;
  ChunkStore& store_;
  std::uint64_t merged_bytes_;
  ByteView view_;
  ByteBuffer message_;
  std::vector<std::uint32_t> wanted_;
  bool all_ = true, order_warned_ = false;
  std::size_t next_chunk_ = 0;
  std::vector<std::uint64_t> opened_;  ///< positions of chunks, by the index of the container
  std::deque<LoadedChunk> storage_;
  std::vector<LoadedChunk*> heap_, free_;
  LoadedChunk* pending_ = nullptr;
};

}  // namespace aslio::io
