#include <fmt/format.h>

#include <algorithm>

#include "../foreign_file.hpp"
#include "aslio/core/errors.hpp"
#include "chunk.hpp"

namespace aslio::io::rosbag {
namespace {

struct FileHeader {
  std::uint64_t index_position = 0, first_record = 0;
  std::uint32_t connections = 0, chunks = 0;
};

/// Names what the file is instead, where its first bytes tell.
std::string instead_of_bag(ByteView& view) {
  const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(view.size(), kForeignHead));
  const std::string_view start(reinterpret_cast<const char*>(view.at(0, count)), count);
  return kMagic.starts_with(start) ? "a bag that ends inside its first line" : foreign_format(start);
}

FileHeader read_file_header(const InputFile& file, ByteView& view, const Limits& limits) {
  const std::string name = file.path().string();
  if (file.size() == 0) throw DataError(fmt::format("{}: the file is empty", name));
  if (file.size() < kMagic.size() ||
      std::string_view(reinterpret_cast<const char*>(view.at(0, kMagic.size())), kMagic.size()) != kMagic) {
    throw DataError(fmt::format("{}: {}", name, instead_of_bag(view)));
  }
  Record record;
  std::string why;
  const Parsed parsed = parse_record(view, kMagic.size(), file.size(), limits, record, why);
  if (parsed == Parsed::header_cut || parsed == Parsed::data_cut) {
    throw DataError(
        fmt::format("{}: the file ends inside its header ({} bytes): there is no message in it; copy it again from its "
                    "origin",
                    name, file.size()));
  }
  if (parsed == Parsed::damaged) throw DataError(fmt::format("{}: damaged bag header: {}", name, why));
  if (record.op != Op::bag_header || !record.index_position) {
    throw DataError(fmt::format("{}: damaged bag header: it is no header record", name));
  }
  if (!record.encryptor.empty()) {
    throw DataError(fmt::format("{}: the bag is encrypted; decrypt it with `rosbag decrypt`", name));
  }
  return {*record.index_position, record.next(), record.connection_count.value_or(0), record.chunk_count.value_or(0)};
}

enum class IndexState : std::uint8_t { good, cut, damaged };

std::string add_chunk_info(ByteView& view, const Record& record, const FileHeader& header, BagIndex& index) {
  if (!record.chunk_position || !record.begin || !record.end) return "a chunk info lacks a field";
  if (*record.chunk_position < header.first_record || *record.chunk_position >= header.index_position) {
    return fmt::format("a chunk info points to offset {}", *record.chunk_position);
  }
  if (*record.begin > *record.end) return "a chunk info ends before it begins";
  ChunkInfo info{*record.chunk_position, *record.begin, *record.end, {}, 0, 0};
  for (std::uint64_t at = 0; at + 8 <= record.data_bytes; at += 8) {
    const std::uint8_t* pair = view.at(record.data_begin + at, 8);
    const std::uint32_t count = load<std::uint32_t>(pair + 4);
    if (count > 0) info.connections.push_back(load<std::uint32_t>(pair));
    info.messages += count;
  }
  std::sort(info.connections.begin(), info.connections.end());
  index.chunks.push_back(std::move(info));
  return {};
}

/// What contradicts itself in a whole index section.
std::string contradiction(const BagIndex& index) {
  std::vector<std::uint64_t> positions;
  for (const ChunkInfo& chunk : index.chunks) {
    positions.push_back(chunk.position);
    const auto unknown = std::find_if_not(chunk.connections.begin(), chunk.connections.end(),
                                          [&](std::uint32_t id) { return index.connections.contains(id); });
    if (unknown != chunk.connections.end()) {
      return fmt::format("a chunk info names connection {}, which does not exist", *unknown);
    }
    if (std::adjacent_find(chunk.connections.begin(), chunk.connections.end()) != chunk.connections.end()) {
      return "a chunk info names one connection twice";
    }
  }
  std::sort(positions.begin(), positions.end());
  if (std::adjacent_find(positions.begin(), positions.end()) != positions.end()) {
    return "two chunk infos point to one chunk";
  }
  return {};
}

/// The index section at the end of a closed bag.
IndexState read_index_section(const InputFile& file, ByteView& view, const FileHeader& header, const Limits& limits,
                              BagIndex& index, std::string& why) {
  if (header.index_position < header.first_record) {
    why = "its position lies before the first record";
    return IndexState::damaged;
  }
  Record record;
  for (std::uint64_t position = header.index_position; position < file.size(); position = record.next()) {
    const Parsed parsed = parse_record(view, position, file.size(), limits, record, why);
    if (parsed == Parsed::damaged) return IndexState::damaged;
    if (parsed != Parsed::ok) return IndexState::cut;
    if (record.op == Op::connection) {
      Connection connection;
      why = parse_connection(view, record, limits, connection);
      if (why.empty()) why = index.connections.add(std::move(connection), limits.connections);
    } else if (record.op == Op::chunk_info) {
      why = add_chunk_info(view, record, header, index);
    } else {
      why = fmt::format("a record of kind {} stands in it", static_cast<int>(record.op));
    }
    if (!why.empty()) return IndexState::damaged;
  }
  if (index.connections.all().size() != header.connections || index.chunks.size() != header.chunks) {
    why = fmt::format("it lists {} connections and {} chunks where the header counts {} and {}",
                      index.connections.all().size(), index.chunks.size(), header.connections, header.chunks);
    return IndexState::cut;
  }
  why = contradiction(index);
  return why.empty() ? IndexState::good : IndexState::damaged;
}

/// Rebuilds the index from the records themselves.
class Scanner {
 public:
  Scanner(const InputFile& file, ByteView& view, const FileHeader& header, const Limits& limits, BagIndex& index)
      : file_(file), view_(view), header_(header), limits_(limits), index_(index), loader_(file, limits) {}

  void run() {
    Record record;
    std::string why;
    for (std::uint64_t position = header_.first_record; position < file_.size(); position = record.next()) {
      const Parsed parsed = parse_record(view_, position, file_.size(), limits_, record, why);
      if (parsed == Parsed::damaged || (parsed != Parsed::header_cut && !take(position, record, parsed, why))) {
        finish_chunk(false);
        damaged(position, why);
        return;
      }
      if (parsed != Parsed::ok) {
        index_.status = InputStatus::truncated;
        finish_chunk(parsed == Parsed::data_cut && record.op == Op::chunk);
        return;
      }
    }
    finish_chunk(false);
  }

 private:
  /// Damage behind the last chunk costs nothing but the index; before it, it costs messages.
  void damaged(std::uint64_t position, const std::string& why) {
    if (header_.index_position != 0 && position >= header_.index_position) return;
    throw DataError(fmt::format(
        "{}: damaged record at offset {}: {}; copy the bag again from its origin, or cut it before this offset",
        file_.path().string(), position, why));
  }

  bool take(std::uint64_t position, const Record& record, Parsed parsed, std::string& why) {
    switch (record.op) {
      case Op::chunk:
        finish_chunk(false);
        open_chunk_ = ChunkInfo{position, kTimeMax, kTimeMin, {}, 0, 0};
        return true;
      case Op::index_data:
        return parsed != Parsed::ok || take_times(record, why);
      case Op::connection: {
        if (parsed != Parsed::ok) return true;
        Connection connection;
        why = parse_connection(view_, record, limits_, connection);
        if (why.empty()) why = index_.connections.add(std::move(connection), limits_.connections);
        return why.empty();
      }
      case Op::chunk_info:
        return true;
      case Op::bag_header:
      case Op::message:
        break;
    }
    why = fmt::format("a record of kind {} where a chunk is expected", static_cast<int>(record.op));
    return false;
  }

  bool take_times(const Record& record, std::string& why) {
    if (!open_chunk_ || !record.connection || !record.count || *record.count * std::uint64_t{12} != record.data_bytes) {
      why = "an index record does not fit the chunk before it";
      return false;
    }
    for (std::uint64_t at = 0; at < record.data_bytes; at += 12) {
      const TimeNs t = load_time(view_.at(record.data_begin + at, 12));
      open_chunk_->begin = std::min(open_chunk_->begin, t);
      open_chunk_->end = std::max(open_chunk_->end, t);
    }
    if (*record.count > 0) open_chunk_->connections.push_back(*record.connection);
    return true;
  }

  void finish_chunk(bool cut) {
    if (!open_chunk_) return;
    ChunkInfo info = std::move(*open_chunk_);
    open_chunk_.reset();
    std::sort(info.connections.begin(), info.connections.end());
    const bool known =
        !info.connections.empty() && std::all_of(info.connections.begin(), info.connections.end(),
                                                 [&](std::uint32_t id) { return index_.connections.contains(id); });
    // A cut may have taken some of the index records of the last chunk: then its own records must tell.
    if (!known || index_.status == InputStatus::truncated) {
      loader_.load(info.position, cut, nullptr, index_.connections, true, scratch_);
      if (scratch_.entries.empty()) return;
      info.begin = scratch_.entries.front().time;
      info.end = scratch_.entries.back().time;
      info.connections.clear();
      for (const MessageEntry& entry : scratch_.entries) info.connections.push_back(entry.connection);
      std::sort(info.connections.begin(), info.connections.end());
      info.connections.erase(std::unique(info.connections.begin(), info.connections.end()), info.connections.end());
    }
    index_.chunks.push_back(std::move(info));
  }

  const InputFile& file_;
  ByteView& view_;
  const FileHeader& header_;
  const Limits& limits_;
  BagIndex& index_;
  ChunkLoader loader_;
  LoadedChunk scratch_;
  std::optional<ChunkInfo> open_chunk_;
};

/// Adds to what the index holds.
void scan(const InputFile& file, ByteView& view, const FileHeader& header, const Limits& limits, BagIndex& index) {
  index.scanned = true;
  Scanner(file, view, header, limits, index).run();
  if (index.status == InputStatus::truncated) {
    index.warnings.push_back(
        fmt::format("the file is cut short at {} bytes: all whole messages are read", file.size()));
  }
  sort_chunks(index.chunks);
}

std::string damaged_index(const std::string& why) {
  return fmt::format("the index is damaged ({}): the bag was scanned instead", why);
}

}  // namespace

BagIndex read_bag_index(const InputFile& file, const Limits& limits) {
  ByteView view(file);
  const FileHeader header = read_file_header(file, view, limits);
  BagIndex index;
  std::string why;
  if (header.index_position != 0) {
    const IndexState state = header.index_position > file.size()
                                 ? IndexState::cut
                                 : read_index_section(file, view, header, limits, index, why);
    if (state == IndexState::good) {
      sort_chunks(index.chunks);
      return index;
    }
    index = BagIndex{};
    if (state == IndexState::cut) index.status = InputStatus::truncated;
    if (state == IndexState::damaged) index.warnings.push_back(damaged_index(why));
  } else {
    index.warnings.push_back("the bag has no index (its recorder did not close it): it was scanned instead");
  }
  scan(file, view, header, limits, index);
  return index;
}

BagIndex scan_damaged_index(const InputFile& file, const Limits& limits, const std::string& why) {
  ByteView view(file);
  const FileHeader header = read_file_header(file, view, limits);
  BagIndex index;
  index.warnings.push_back(damaged_index(why));
  scan(file, view, header, limits, index);
  return index;
}

}  // namespace aslio::io::rosbag
