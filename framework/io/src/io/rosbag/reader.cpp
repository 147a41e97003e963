#include "aslio/io/rosbag/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "chunk.hpp"

namespace aslio::io::rosbag {

class BagReader::Impl {
 public:
  Impl(const std::filesystem::path& path, const Limits& limits)
      : file_(path), limits_(limits), index_(read_bag_index(file_, limits_)), loader_(file_, limits_), view_(file_) {}

  const BagIndex& index() const { return index_; }

  void select(std::span<const std::uint32_t> ids) {
    wanted_.assign(ids.begin(), ids.end());
    std::sort(wanted_.begin(), wanted_.end());
    all_ = false;
    next_chunk_ = 0;
    opened_.clear();
    while (!heap_.empty()) retire();
  }

  bool next(BagMessage& message) {
    while (more_chunks() && (heap_.empty() || must_open_next())) open_next();
    if (heap_.empty()) return false;
    std::pop_heap(heap_.begin(), heap_.end(), later_);
    Active& active = *heap_.back();
    const MessageEntry entry = active.chunk.entries[active.next++];
    message.connection = entry.connection;
    message.time = entry.time;
    message.bytes = bytes_of(active.chunk, entry);
    if (active.next < active.chunk.entries.size()) {
      std::push_heap(heap_.begin(), heap_.end(), later_);
    } else {
      // The span just handed out may lie in this chunk: its storage stays untouched until the next call.
      pending_ = heap_.back();
      heap_.pop_back();
    }
    return true;
  }

 private:
  struct Active {
    LoadedChunk chunk;
    std::size_t next = 0;
    std::uint64_t position = 0;
    std::size_t order = 0;
    const MessageEntry& head() const { return chunk.entries[next]; }
  };

  /// Heap order: the earliest message on top; equal times by order of the chunks.
  struct Later {
    bool operator()(const Active* a, const Active* b) const {
      return a->head().time != b->head().time ? a->head().time > b->head().time : a->order > b->order;
    }
  };

  /// Steps over chunks that were opened before the index was rebuilt.
  bool more_chunks() {
    const auto opened = [&] {
      return index_.scanned && std::binary_search(opened_.begin(), opened_.end(), index_.chunks[next_chunk_].position);
    };
    while (next_chunk_ < index_.chunks.size() && opened()) ++next_chunk_;
    return next_chunk_ < index_.chunks.size();
  }

  bool wanted(const ChunkInfo& info) const {
    return all_ || info.connections.empty() ||
           std::any_of(info.connections.begin(), info.connections.end(),
                       [&](std::uint32_t id) { return std::binary_search(wanted_.begin(), wanted_.end(), id); });
  }

  bool must_open_next() {
    if (index_.chunks[next_chunk_].begin > heap_.front()->head().time) return false;
    std::uint64_t held = 0;
    for (const Active* active : heap_) held += active->chunk.memory.size();
    if (held < limits_.merged_chunk_bytes) return true;
    if (!order_warned_) {
      index_.warnings.push_back(
          fmt::format("compressed chunks that overlap in time hold more than {} MB: messages come in approximate order",
                      limits_.merged_chunk_bytes >> 20U));
      order_warned_ = true;
    }
    return false;
  }

  void open_next() {
    const ChunkInfo& info = index_.chunks[next_chunk_++];
    if (!wanted(info)) return;
    Active* slot = acquire();
    slot->next = 0;
    slot->position = info.position;
    slot->order = next_chunk_;
    const bool may_be_cut = index_.status == InputStatus::truncated;
    try {
      loader_.load(info.position, may_be_cut, all_ ? nullptr : &wanted_, index_.connections, false, slot->chunk);
    } catch (...) {
      free_.push_back(slot);
      throw;
    }
    const std::string why = index_.scanned ? std::string{} : disagreement(info, slot->chunk);
    if (!index_.scanned) opened_.push_back(info.position);
    if (slot->chunk.entries.empty()) {
      free_.push_back(slot);
    } else {
      heap_.push_back(slot);
      std::push_heap(heap_.begin(), heap_.end(), later_);
    }
    if (!why.empty()) rebuild_index(why);
  }

  /// How a chunk differs from what the index says of it; empty where it does not.
  static std::string disagreement(const ChunkInfo& info, const LoadedChunk& chunk) {
    const bool times = chunk.messages == 0 || (chunk.begin == info.begin && chunk.end == info.end);
    if (times && chunk.messages == info.messages) return {};
    return fmt::format(
        "it tells of {} messages from {} to {} ns in the chunk at offset {}, which has {} from {} to {} ns",
        info.messages, info.begin, info.end, info.position, chunk.messages, chunk.begin, chunk.end);
  }

  /// In the middle of reading: what is open stays, what is not comes by the new index. A chunk that the old one had too
  /// late, or as one of other topics, comes late. The connections stay, callers hold them.
  void rebuild_index(const std::string& why) {
    BagIndex scanned = scan_damaged_index(file_, limits_, why);
    index_.scanned = true;
    index_.chunks = std::move(scanned.chunks);
    if (scanned.status == InputStatus::truncated) index_.status = InputStatus::truncated;
    index_.warnings.insert(index_.warnings.end(), scanned.warnings.begin(), scanned.warnings.end());
    next_chunk_ = 0;
    std::sort(opened_.begin(), opened_.end());
    for (Active* active : heap_) {
      const auto at = std::find_if(index_.chunks.begin(), index_.chunks.end(),
                                   [&](const ChunkInfo& info) { return info.position == active->position; });
      active->order = static_cast<std::size_t>(at - index_.chunks.begin()) + 1;
    }
    std::make_heap(heap_.begin(), heap_.end(), later_);
  }

  Active* acquire() {
    if (pending_ != nullptr) {
      free_.push_back(pending_);
      pending_ = nullptr;
    }
    if (free_.empty()) return &storage_.emplace_back();
    Active* slot = free_.back();
    free_.pop_back();
    return slot;
  }

  void retire() {
    free_.push_back(heap_.back());
    heap_.pop_back();
  }

  std::span<const std::uint8_t> bytes_of(const LoadedChunk& chunk, const MessageEntry& entry) {
    if (chunk.in_memory) return std::span(chunk.memory).subspan(static_cast<std::size_t>(entry.offset), entry.bytes);
    constexpr std::uint32_t kSmall = 16 * 1024;
    if (entry.bytes <= kSmall) return {view_.at(entry.offset, entry.bytes), entry.bytes};
    if (message_.size() < entry.bytes) message_.resize(entry.bytes);
    const std::span<std::uint8_t> to = std::span(message_).first(entry.bytes);
    file_.read(entry.offset, to);
    return to;
  }

  InputFile file_;
  Limits limits_;
  BagIndex index_;
  ChunkLoader loader_;
  ByteView view_;
  std::vector<std::uint8_t> message_;
  std::vector<std::uint32_t> wanted_;
  bool all_ = true, order_warned_ = false;
  std::size_t next_chunk_ = 0;
  std::vector<std::uint64_t> opened_;  ///< positions of chunks, by the index of the bag
  std::deque<Active> storage_;
  std::vector<Active*> heap_, free_;
  Active* pending_ = nullptr;
  Later later_;
};

BagReader::BagReader(const std::filesystem::path& path, const Limits& limits)
    : impl_(std::make_unique<Impl>(path, limits)) {}
BagReader::~BagReader() = default;
BagReader::BagReader(BagReader&&) noexcept = default;
BagReader& BagReader::operator=(BagReader&&) noexcept = default;

const std::vector<Connection>& BagReader::connections() const { return impl_->index().connections.all(); }

std::optional<TimeNs> BagReader::begin_time() const {
  if (impl_->index().chunks.empty()) return std::nullopt;
  return impl_->index().chunks.front().begin;
}

std::optional<TimeNs> BagReader::end_time() const {
  std::optional<TimeNs> end;
  for (const ChunkInfo& chunk : impl_->index().chunks) end = std::max(end.value_or(chunk.end), chunk.end);
  return end;
}

void BagReader::select(std::span<const std::uint32_t> ids) { impl_->select(ids); }
bool BagReader::next(BagMessage& message) { return impl_->next(message); }
InputStatus BagReader::status() const { return impl_->index().status; }
const std::vector<std::string>& BagReader::warnings() const { return impl_->index().warnings; }

}  // namespace aslio::io::rosbag
