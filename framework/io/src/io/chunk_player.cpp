#include "chunk_player.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace aslio::io {
namespace {

/// Heap order: the earliest message on top; equal times in file order.
bool later(const LoadedChunk* a, const LoadedChunk* b) {
  const TimeNs first = a->entries[a->next].time, second = b->entries[b->next].time;
  return first != second ? first > second : a->position > b->position;
}

}  // namespace

void sort_chunks(std::vector<ChunkInfo>& chunks) {
  std::stable_sort(chunks.begin(), chunks.end(), [](const ChunkInfo& a, const ChunkInfo& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.position < b.position;
  });
}

void LoadedChunk::start_over(std::uint64_t at) {
  position = at;
  entries.clear();
  connections.clear();
  next = 0;
  memory.shrink(0);
  in_memory = cut = false;
  messages = 0;
  begin = kTimeMax;
  end = kTimeMin;
}

void LoadedChunk::put_in_order() {
  const auto earlier = [](const MessageEntry& a, const MessageEntry& b) { return a.time < b.time; };
  if (!std::is_sorted(entries.begin(), entries.end(), earlier)) {
    std::stable_sort(entries.begin(), entries.end(), earlier);
  }
}

void ChunkPlayer::select(std::span<const std::uint32_t> ids) {
  wanted_.assign(ids.begin(), ids.end());
  std::sort(wanted_.begin(), wanted_.end());
  all_ = false;
  next_chunk_ = 0;
  opened_.clear();
  for (LoadedChunk* chunk : heap_) give_back(chunk);
  heap_.clear();
}

bool ChunkPlayer::next(RawMessage& message) {
  while (more_chunks() && (heap_.empty() || must_open_next())) open_next();
  if (heap_.empty()) return false;
  std::pop_heap(heap_.begin(), heap_.end(), later);
  LoadedChunk& chunk = *heap_.back();
  const MessageEntry entry = chunk.entries[chunk.next++];
  message.connection = entry.connection;
  message.time = entry.time;
  message.bytes = bytes_of(chunk, entry);
  if (chunk.next < chunk.entries.size()) {
    std::push_heap(heap_.begin(), heap_.end(), later);
  } else {
    // The span just handed out may lie in this chunk: its storage stays untouched until the next call.
    pending_ = heap_.back();
    heap_.pop_back();
  }
  return true;
}

/// Steps over chunks that were opened before the index was rebuilt.
bool ChunkPlayer::more_chunks() {
  const std::vector<ChunkInfo>& chunks = store_.chunks();
  const auto opened = [&] {
    return store_.scanned() && std::binary_search(opened_.begin(), opened_.end(), chunks[next_chunk_].position);
  };
  while (next_chunk_ < chunks.size() && opened()) ++next_chunk_;
  return next_chunk_ < chunks.size();
}

bool ChunkPlayer::wanted(const ChunkInfo& info) const {
  return all_ || info.connections.empty() ||
         std::any_of(info.connections.begin(), info.connections.end(),
                     [&](std::uint32_t id) { return std::binary_search(wanted_.begin(), wanted_.end(), id); });
}

bool ChunkPlayer::must_open_next() {
  const LoadedChunk& first = *heap_.front();
  if (store_.chunks()[next_chunk_].begin > first.entries[first.next].time) return false;
  std::uint64_t held = 0;
  for (const LoadedChunk* chunk : heap_) held += chunk->held_bytes();
  if (held < merged_bytes_) return true;
  if (!order_warned_) {
    store_.warn(fmt::format("chunks that overlap in time hold more than {} MB: messages come in approximate order",
                            merged_bytes_ >> 20U));
    order_warned_ = true;
  }
  return false;
}

void ChunkPlayer::open_next() {
  const ChunkInfo& info = store_.chunks()[next_chunk_++];
  if (!wanted(info)) return;
  LoadedChunk* chunk = acquire();
  chunk->start_over(info.position);
  try {
    store_.load(info, all_ ? nullptr : &wanted_, *chunk);
  } catch (...) {
    give_back(chunk);
    throw;
  }
  const std::string why = store_.scanned() ? std::string{} : store_.disagreement(info, *chunk);
  if (!store_.scanned()) opened_.push_back(info.position);
  if (chunk->entries.empty()) {
    give_back(chunk);
  } else {
    heap_.push_back(chunk);
    std::push_heap(heap_.begin(), heap_.end(), later);
  }
  if (!why.empty()) rebuild_index(why);
}

/// In the middle of reading: what is open stays, what is not comes by the new index. A chunk that the old one had too
/// late, or as one of other topics, comes late. The connections stay, callers hold them.
void ChunkPlayer::rebuild_index(const std::string& why) {
  store_.rescan(why);
  next_chunk_ = 0;
  std::sort(opened_.begin(), opened_.end());
}

LoadedChunk* ChunkPlayer::acquire() {
  if (pending_ != nullptr) {
    give_back(pending_);
    pending_ = nullptr;
  }
  if (free_.empty()) return &storage_.emplace_back();
  LoadedChunk* chunk = free_.back();
  free_.pop_back();
  return chunk;
}

void ChunkPlayer::give_back(LoadedChunk* chunk) {
  if (chunk->memory.capacity() > merged_bytes_) chunk->memory.release();
  free_.push_back(chunk);
}

std::span<const std::uint8_t> ChunkPlayer::bytes_of(const LoadedChunk& chunk, const MessageEntry& entry) {
  if (chunk.in_memory) return chunk.memory.bytes().subspan(static_cast<std::size_t>(entry.offset), entry.bytes);
  constexpr std::uint32_t kSmall = 16 * 1024;
  if (entry.bytes <= kSmall) return {view_.at(entry.offset, entry.bytes), entry.bytes};
  message_.reset(entry.bytes);
  const std::span<std::uint8_t> to(message_.data(), entry.bytes);
  file_.read(entry.offset, to);
  return to;
}

}  // namespace aslio::io
