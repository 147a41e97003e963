#include "reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "index.hpp"

namespace aslio::io::mcap {

class McapReader::Impl final : public ChunkStore {
 public:
  Impl(const std::filesystem::path& path, const Limits& limits)
      : file_(path),
        limits_(limits),
        index_(read_index(file_, limits_)),
        connections_(index_.channels.connections()),
        loader_(file_, limits_),
        player_(file_, *this, limits.merged_chunk_bytes) {
    for (const Connection& c : connections_) encodings_.emplace(c.id, c.encoding);
    expect(nullptr);
  }

  const Index& index() const { return index_; }
  const std::vector<Connection>& connections() const { return connections_; }

  void select(std::span<const std::uint32_t> ids) {
    player_.select(ids);
    expect(&ids);
  }

  bool next(RawMessage& message) {
    while (!player_.next(message)) {
      check_all_read();
      if (!missing()) return false;
      player_.rebuild_index(fmt::format("its statistics tell of {} messages where {} were found", *expected_, given_));
    }
    ++given_;
    message.encoding = encodings_.at(message.connection);
    return true;
  }

  const std::vector<ChunkInfo>& chunks() const override { return index_.chunks; }
  bool scanned() const override { return index_.by_content; }

  void load(const ChunkInfo& info, const std::vector<std::uint32_t>* wanted, LoadedChunk& out) override {
    const bool may_be_cut = index_.status == InputStatus::truncated;
    loader_.load(info, {wanted, may_be_cut, false, &index_.checksum}, index_.channels, out);
  }

  std::string disagreement(const ChunkInfo& info, const LoadedChunk& chunk) const override {
    const bool times = chunk.messages == 0 || (chunk.begin == info.begin && chunk.end == info.end);
    if (!times) {
      return fmt::format(
          "it tells of messages from {} to {} ns in the chunk at offset {}, which has them from {} to {} ns",
          info.begin, info.end, info.position, chunk.begin, chunk.end);
    }
    // Channels without a message in the chunk do no harm.
    const auto lacking = std::find_if_not(chunk.connections.begin(), chunk.connections.end(), [&](std::uint32_t id) {
      return std::binary_search(info.connections.begin(), info.connections.end(), id);
    });
    if (lacking == chunk.connections.end()) return {};
    return fmt::format("it tells of no message of channel {} in the chunk at offset {}, which has some", *lacking,
                       info.position);
  }

  void rescan(const std::string& why) override {
    Index scanned = scan_content(file_, limits_, why);
    index_.by_content = true;
    index_.chunks = std::move(scanned.chunks);
    if (scanned.status == InputStatus::truncated) index_.status = InputStatus::truncated;
    index_.warnings.insert(index_.warnings.end(), scanned.warnings.begin(), scanned.warnings.end());
  }

  void warn(const std::string& text) override { index_.warnings.push_back(text); }

 private:
  /// Starts to count against the statistics of `ids`; null: of all channels.
  void expect(const std::span<const std::uint32_t>* ids) {
    given_ = 0;
    expected_.reset();
    if (index_.counts.empty() || index_.by_content) return;
    std::uint64_t sum = 0;
    for (const auto& [id, count] : index_.counts) {
      if (ids == nullptr || std::find(ids->begin(), ids->end(), id) != ids->end()) sum += count;
    }
    expected_ = sum;
  }

  bool missing() const { return expected_ && given_ < *expected_ && !index_.by_content; }

  /// Once all chunks have been read, no more than the rest of the file has to be read for its checksum.
  void check_all_read() {
    const auto is_chunk = [](const ChunkInfo& info) { return info.file_end == 0; };
    const auto chunks = std::count_if(index_.chunks.begin(), index_.chunks.end(), is_chunk);
    if (index_.checksum.parts() >= static_cast<std::size_t>(chunks)) index_.checksum.check(file_);
  }

  InputFile file_;
  Limits limits_;
  Index index_;
  std::vector<Connection> connections_;
  std::map<std::uint32_t, Encoding> encodings_;
  ChunkLoader loader_;
  ChunkPlayer player_;
  std::uint64_t given_ = 0;
  std::optional<std::uint64_t> expected_;
};

McapReader::McapReader(const std::filesystem::path& path, const Limits& limits)
    : impl_(std::make_unique<Impl>(path, limits)) {}
McapReader::~McapReader() = default;
McapReader::McapReader(McapReader&&) noexcept = default;
McapReader& McapReader::operator=(McapReader&&) noexcept = default;

const std::vector<Connection>& McapReader::connections() const { return impl_->connections(); }

std::optional<TimeNs> McapReader::begin_time() const {
  if (impl_->index().chunks.empty()) return std::nullopt;
  return impl_->index().chunks.front().begin;
}

std::optional<TimeNs> McapReader::end_time() const {
  std::optional<TimeNs> end;
  for (const ChunkInfo& chunk : impl_->index().chunks) end = std::max(end.value_or(chunk.end), chunk.end);
  return end;
}

void McapReader::select(std::span<const std::uint32_t> ids) { impl_->select(ids); }
bool McapReader::next(RawMessage& message) { return impl_->next(message); }
InputStatus McapReader::status() const { return impl_->index().status; }
const std::vector<std::string>& McapReader::warnings() const { return impl_->index().warnings; }

}  // namespace aslio::io::mcap
