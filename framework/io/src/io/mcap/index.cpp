#include "index.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "walk.hpp"

namespace aslio::io::mcap {
namespace {

/// Names what the file is instead, where its first bytes tell.
std::string foreign_format(ByteView& view) {
  const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(view.size(), kMagic.size()));
  const std::string_view start(reinterpret_cast<const char*>(view.at(0, count)), count);
  if (kMagic.starts_with(start))
    return "an MCAP file that ends inside its first 8 bytes; copy it again from its origin";
  if (start.starts_with(kMagic.substr(0, 5))) return "an MCAP file of another version; convert it with the `mcap` tool";
  return "not an MCAP file (it does not start with 89 4D 43 41 50 30 0D 0A)";
}

Frame read_frame(const InputFile& file, ByteView& view) {
  const std::string name = file.path().string();
  if (file.size() == 0) throw DataError(fmt::format("{}: the file is empty", name));
  if (file.size() < kMagic.size() || std::memcmp(view.at(0, kMagic.size()), kMagic.data(), kMagic.size()) != 0) {
    throw DataError(fmt::format("{}: {}", name, foreign_format(view)));
  }
  Record record;
  const Parsed parsed = parse_record(view, kMagic.size(), file.size(), record);
  if (parsed == Parsed::head_cut || (parsed == Parsed::data_cut && record.op == Op::header)) {
    throw DataError(
        fmt::format("{}: the file ends inside its header ({} bytes): there is no message in it; copy it again from its "
                    "origin",
                    name, file.size()));
  }
  if (parsed != Parsed::ok || record.op != Op::header) {
    throw DataError(fmt::format("{}: damaged header at offset {}: no header record stands there; {}", name,
                                kMagic.size(), kRemedy));
  }
  Frame frame{record.next(), file.size(), false, {}};
  constexpr std::uint64_t kTail = kHeadBytes + kFooterBytes + kMagic.size();
  if (file.size() - frame.first_record < kTail) return frame;
  const std::uint64_t footer = file.size() - kTail, magic = file.size() - kMagic.size();
  if (std::memcmp(view.at(magic, kMagic.size()), kMagic.data(), kMagic.size()) != 0) return frame;
  if (parse_record(view, footer, magic, record) != Parsed::ok || record.op != Op::footer) return frame;
  if (record.data_bytes != kFooterBytes) return frame;
  frame.footer = *parse_footer({view.at(record.data_begin, kFooterBytes), kFooterBytes});
  frame.closed = true;
  frame.end = footer;
  return frame;
}

/// What contradicts itself in the list of chunks.
std::string contradiction(const std::vector<ChunkIndex>& chunks, const Frame& frame) {
  std::uint64_t free = frame.first_record;
  for (const ChunkIndex& chunk : chunks) {
    const std::uint64_t end = frame.footer.summary_begin;
    if (chunk.position < free || chunk.position > end || chunk.bytes < kHeadBytes ||
        chunk.bytes > end - chunk.position || chunk.index_bytes > end - chunk.position - chunk.bytes) {
      return fmt::format("it names a chunk of {} bytes at offset {}, where there is no room for it", chunk.bytes,
                         chunk.position);
    }
    free = chunk.position + chunk.bytes + chunk.index_bytes;
  }
  return {};
}

void take_statistics(Bytes content, Index& index) {
  Fields fields(content);
  fields.bytes(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8);  // counts of all kinds, and times
  Fields counts(fields.sized());
  while (!counts.empty()) {
    const auto channel = counts.number<std::uint16_t>();
    index.counts[channel] = counts.number<std::uint64_t>();
  }
  if (!fields.whole() || !counts.whole()) index.counts.clear();
}

std::string take_summary_record(ByteView& view, const Record& record, const Limits& limits, Index& index,
                                std::vector<ChunkIndex>& chunks) {
  if (record.op == Op::schema || record.op == Op::channel) {
    return learn_description(view, record, limits, index.channels);
  }
  if (record.op == Op::data_end || record.op == Op::message || record.op == Op::chunk) {
    return fmt::format("a record of kind {} stands in it", static_cast<int>(record.op));
  }
  if (record.op != Op::chunk_index && record.op != Op::statistics) return {};
  if (record.data_bytes > limits.record_bytes) {
    return fmt::format("a record claims {} bytes (at most {})", record.data_bytes, limits.record_bytes);
  }
  const std::size_t bytes = static_cast<std::size_t>(record.data_bytes);
  const Bytes content{view.at(record.data_begin, bytes), bytes};
  if (record.op == Op::statistics) {
    take_statistics(content, index);
    return {};
  }
  auto chunk = parse_chunk_index(content);
  if (!chunk) return "a chunk index is shorter than its fields";
  chunks.push_back(std::move(*chunk));
  return {};
}

/// Returns what is wrong with it.
std::string read_summary(const InputFile& file, ByteView& view, const Frame& frame, const Limits& limits, Index& index,
                         std::vector<ChunkIndex>& chunks) {
  const std::uint64_t begin = frame.footer.summary_begin;
  if (begin < frame.first_record || begin > frame.end) return fmt::format("its position {} lies outside", begin);
  if (frame.footer.summary_crc != 0) {
    constexpr std::uint64_t kSummed = kHeadBytes + kFooterBytes - 4;  // of the footer: all but the checksum
    const std::uint32_t found = crc32_of(file, begin, frame.end + kSummed - begin);
    if (found != frame.footer.summary_crc) return "its checksum is wrong";
  }
  Record record;
  for (std::uint64_t position = begin; position < frame.end; position = record.next()) {
    if (parse_record(view, position, frame.end, record) != Parsed::ok) {
      return fmt::format("no record stands at offset {}", position);
    }
    std::string why = take_summary_record(view, record, limits, index, chunks);
    if (!why.empty()) return why;
  }
  const auto earlier = [](const ChunkIndex& a, const ChunkIndex& b) { return a.position < b.position; };
  std::sort(chunks.begin(), chunks.end(), earlier);
  return contradiction(chunks, frame);
}

void scan(const InputFile& file, const Frame& frame, const Limits& limits, bool by_content, Index& index) {
  const Walk::Plan plan{{}, false, by_content};
  Walk walk(file, limits, frame, plan, index);
  const std::string why = walk.run();
  if (!why.empty()) {
    throw DataError(
        fmt::format("{}: damaged record at offset {}: {}; {}", file.path().string(), walk.position(), why, kRemedy));
  }
  index.by_content = by_content;
  if (index.status == InputStatus::truncated) {
    index.warnings.push_back(
        fmt::format("the file is cut short at {} bytes: all whole messages are read", file.size()));
  }
  sort_chunks(index.chunks);
}

Index empty_index(const InputFile& file, const Limits& limits) {
  return {ChannelTable(file.path().string(), limits), {}, {}, {}, InputStatus::complete, {}, false};
}

std::string damaged_index(const std::string& why) {
  return fmt::format("the index is damaged ({}): the file was scanned instead", why);
}

bool has_chunks(const Index& index) {
  return std::any_of(index.chunks.begin(), index.chunks.end(), [](const ChunkInfo& c) { return c.file_end == 0; });
}

}  // namespace

Index read_index(const InputFile& file, const Limits& limits) {
  ByteView view(file);
  const Frame frame = read_frame(file, view);
  Index index = empty_index(file, limits);
  if (frame.closed && frame.footer.summary_begin != 0) {
    Walk::Plan plan;
    std::string why = read_summary(file, view, frame, limits, index, plan.chunks);
    plan.indexed = !plan.chunks.empty();
    if (why.empty()) {
      Frame data = frame;
      data.end = frame.footer.summary_begin;
      why = Walk(file, limits, data, plan, index).run();
    }
    if (why.empty()) {
      sort_chunks(index.chunks);
      return index;
    }
    index = empty_index(file, limits);
    index.warnings.push_back(damaged_index(why));
  }
  const bool told = !index.warnings.empty();
  scan(file, frame, limits, false, index);
  if (!told && frame.closed && has_chunks(index)) {
    index.warnings.push_back("the file has no index: it was scanned instead");
  }
  return index;
}

Index scan_content(const InputFile& file, const Limits& limits, const std::string& why) {
  ByteView view(file);
  Index index = empty_index(file, limits);
  index.warnings.push_back(damaged_index(why));
  scan(file, read_frame(file, view), limits, true, index);
  return index;
}

}  // namespace aslio::io::mcap
