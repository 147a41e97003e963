#include "aslio/io/rosbag/reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "chunk.hpp"

namespace aslio::io::rosbag {

class BagReader::Impl final : public ChunkStore {
 public:
  Impl(const std::filesystem::path& path, const Limits& limits)
      : file_(path),
        limits_(limits),
        index_(read_bag_index(file_, limits_)),
        loader_(file_, limits_),
        player_(file_, *this, limits.merged_chunk_bytes) {}

  const BagIndex& index() const { return index_; }
  ChunkPlayer& player() { return player_; }

  const std::vector<ChunkInfo>& chunks() const override { return index_.chunks; }
  bool scanned() const override { return index_.scanned; }

  void load(const ChunkInfo& info, const std::vector<std::uint32_t>* wanted, LoadedChunk& out) override {
    const bool may_be_cut = index_.status == InputStatus::truncated;
    loader_.load(info.position, may_be_cut, wanted, index_.connections, false, out);
  }

  std::string disagreement(const ChunkInfo& info, const LoadedChunk& chunk) const override {
    const bool times = chunk.messages == 0 || (chunk.begin == info.begin && chunk.end == info.end);
    if (times && chunk.messages == info.messages) return {};
    return fmt::format(
        "it tells of {} messages from {} to {} ns in the chunk at offset {}, which has {} from {} to {} ns",
        info.messages, info.begin, info.end, info.position, chunk.messages, chunk.begin, chunk.end);
  }

  void rescan(const std::string& why) override {
    BagIndex scanned = scan_damaged_index(file_, limits_, why);
    index_.scanned = true;
    index_.chunks = std::move(scanned.chunks);
    if (scanned.status == InputStatus::truncated) index_.status = InputStatus::truncated;
    index_.warnings.insert(index_.warnings.end(), scanned.warnings.begin(), scanned.warnings.end());
  }

  void warn(const std::string& text) override { index_.warnings.push_back(text); }

 private:
  InputFile file_;
  Limits limits_;
  BagIndex index_;
  ChunkLoader loader_;
  ChunkPlayer player_;
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

void BagReader::select(std::span<const std::uint32_t> ids) { impl_->player().select(ids); }
bool BagReader::next(BagMessage& message) {
  message.encoding = Encoding::ros1;
  return impl_->player().next(message);
}
InputStatus BagReader::status() const { return impl_->index().status; }
const std::vector<std::string>& BagReader::warnings() const { return impl_->index().warnings; }

}  // namespace aslio::io::rosbag
