#include "chunk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "../decompress.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::io::mcap {
namespace {

/// Calls `schema` or `channel` with what `record` describes; returns what is wrong.
template <class TakeSchema, class TakeChannel>
std::string with_description(ByteView& view, const Record& record, const Limits& limits, TakeSchema&& schema,
                             TakeChannel&& channel) {
  if (record.data_bytes > limits.record_bytes) {
    return fmt::format("a description claims {} bytes (at most {})", record.data_bytes, limits.record_bytes);
  }
  const std::size_t bytes = static_cast<std::size_t>(record.data_bytes);
  const Bytes content{view.at(record.data_begin, bytes), bytes};
  constexpr const char* kShort = "a description is shorter than its fields";
  if (record.op == Op::schema) {
    auto found = parse_schema(content);
    return found ? schema(std::move(*found)) : kShort;
  }
  auto found = parse_channel(content);
  return found ? channel(std::move(*found)) : kShort;
}

/// Kinds that may stand between messages.
bool may_be_skipped(Op op, bool in_chunk) {
  if (static_cast<std::uint8_t>(op) >= kFirstForeignOp) return true;
  return !in_chunk && (op == Op::message_index || op == Op::attachment || op == Op::metadata);
}

}  // namespace

std::string learn_description(ByteView& view, const Record& record, const Limits& limits, ChannelTable& table) {
  const auto add = [&](auto found) { return table.add(std::move(found)); };
  return with_description(view, record, limits, add, add);
}

void check_message_length(const InputFile& file, const Record& record, const Limits& limits) {
  const std::uint64_t most = std::min<std::uint64_t>(limits.message_bytes, std::numeric_limits<std::uint32_t>::max());
  if (record.data_bytes <= most + kMessageFields) return;
  throw DataError(
      fmt::format("{}: a message at offset {} has {} bytes, the limit of this reader is {}; leave its topic out: `mcap "
                  "filter IN -o OUT -y TOPIC` with the topics you need",
                  file.path().string(), record.position, record.data_bytes - kMessageFields, most));
}

/// Where records are listed.
struct ChunkLoader::Region {
  ByteView& view;
  std::uint64_t begin, end;
  bool in_chunk;
};

void ChunkLoader::damaged(std::uint64_t position, const std::string& why) const {
  throw DataError(fmt::format("{}: damaged chunk at offset {}: {}; {}", file_.path().string(), position, why, kRemedy));
}

void ChunkLoader::check_sizes(std::uint64_t position, const ChunkHead& head) const {
  if (head.declared > limits_.chunk_bytes) {
    throw DataError(fmt::format(
        "{}: the chunk at offset {} decompresses to {} bytes, the limit of this reader is {}; write the file "
        "anew with smaller chunks: `mcap compress IN -o OUT --chunk-size 4194304`",
        file_.path().string(), position, head.declared, limits_.chunk_bytes));
  }
  // A frame has some bytes of its own, also around nothing.
  if (head.declared / limits_.chunk_ratio > head.data_bytes) {
    damaged(position, fmt::format("{} bytes claim to decompress to {} (at most {} times as many)", head.data_bytes,
                                  head.declared, limits_.chunk_ratio));
  }
  // Incompressible data grow a little; far more than the content is no honest chunk.
  if (head.data_bytes > head.declared + head.declared / 4 + 4096) {
    damaged(position, fmt::format("{} compressed bytes for {} decompressed ones", head.data_bytes, head.declared));
  }
}

void ChunkLoader::compare_crc(std::uint64_t position, const ChunkHead& head, std::uint32_t found) const {
  if (head.crc == 0 || head.crc == found) return;
  damaged(position, fmt::format("its checksum is {:08x}, {:08x} is written in front of it", found, head.crc));
}

void ChunkLoader::decompress_into(std::uint64_t position, const ChunkHead& head, const Task& task, LoadedChunk& out) {
  const bool lz4 = head.compression == "lz4";
  if (!lz4 && head.compression != "zstd") {
    std::string name = head.compression.substr(0, 32);
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, '?');
    throw DataError(fmt::format(
        "{}: the chunk at offset {} has the compression '{}' (none, lz4 and zstd are known); write the file "
        "anew: `mcap compress IN -o OUT`, or copy it again if this name is none",
        file_.path().string(), position, name));
  }
  check_sizes(position, head);
  out.in_memory = true;
  if (head.declared == 0 && head.data_bytes == 0) return;
  const std::uint64_t present = std::min(head.data_bytes, file_.size() - head.data_begin);
  compressed_.reset(static_cast<std::size_t>(present));
  file_.read(head.data_begin, {compressed_.data(), compressed_.size()});
  if (task.checksum != nullptr && task.checksum->open() && !out.cut) {
    task.checksum->add(head.data_begin, head.data_bytes, crc32_of(compressed_.bytes()));
  }
  const std::string why = decompress(lz4 ? ChunkCoding::lz4 : ChunkCoding::zstd, compressed_.bytes(),
                                     static_cast<std::size_t>(head.declared), out.memory);
  if (!why.empty() && !out.cut) damaged(position, why);
  if (!out.cut && head.crc != 0) compare_crc(position, head, crc32_of(out.memory.bytes()));
}

/// A chunk that is not compressed stays in the file.
void ChunkLoader::check_stored(std::uint64_t position, const ChunkHead& head, const Task& task) {
  if (head.declared != head.data_bytes) {
    damaged(position, fmt::format("it declares {} bytes and holds {}", head.declared, head.data_bytes));
  }
  const bool summed = task.checksum != nullptr && task.checksum->open();
  if (head.crc == 0 && !summed) return;
  const std::uint32_t found = crc32_of(file_, head.data_begin, head.data_bytes);
  compare_crc(position, head, found);
  if (summed) task.checksum->add(head.data_begin, head.data_bytes, found);
}

void ChunkLoader::load_chunk(const ChunkInfo& info, const Task& task, ChannelTable& table, LoadedChunk& out) {
  Record record;
  const Parsed parsed = parse_record(view_, info.position, file_.size(), record);
  out.cut = parsed == Parsed::data_cut || parsed == Parsed::head_cut;
  if (out.cut && !task.may_be_cut) damaged(info.position, "the file ends inside it");
  if (parsed == Parsed::head_cut) return;
  if (record.op != Op::chunk) damaged(info.position, "no chunk stands there");
  const std::optional<ChunkHead> head = parse_chunk_head(view_, record);
  if (!head && out.cut) return;
  if (!head) damaged(info.position, "its fields do not fit its length");
  std::string why;
  if (head->compression.empty()) {
    if (!out.cut) check_stored(info.position, *head, task);
    const std::uint64_t end = head->data_begin + std::min(head->data_bytes, file_.size() - head->data_begin);
    why = list({view_, head->data_begin, end, true}, task, table, out);
  } else {
    decompress_into(info.position, *head, task, out);
    ByteView memory{out.memory.bytes()};
    why = list({memory, 0, out.memory.size(), true}, task, table, out);
  }
  if (!why.empty()) damaged(info.position, why);
  if (head->crc == 0 && task.checksum != nullptr) task.checksum->check(file_);
}

void ChunkLoader::load(const ChunkInfo& info, const Task& task, ChannelTable& table, LoadedChunk& out) {
  out.start_over(info.position);
  seen_.reset();
  if (info.file_end == 0) {
    load_chunk(info, task, table, out);
  } else {
    if (task.checksum != nullptr) task.checksum->check(file_);
    const std::string why = list({view_, info.position, info.file_end, false}, task, table, out);
    if (!why.empty()) damaged(info.position, why);
  }
  for (std::size_t id = seen_._Find_first(); id < seen_.size(); id = seen_._Find_next(id)) {
    out.connections.push_back(static_cast<std::uint32_t>(id));
  }
  out.put_in_order();
}

std::string ChunkLoader::list(const Region& region, const Task& task, ChannelTable& table, LoadedChunk& out) {
  Record record;
  for (std::uint64_t position = region.begin; position < region.end; position = record.next()) {
    switch (parse_record(region.view, position, region.end, record)) {
      case Parsed::ok:
        break;
      case Parsed::no_record:
        return "a record of kind 0 where messages are expected";
      case Parsed::head_cut:
      case Parsed::data_cut:
        return out.cut ? std::string{} : "a record reaches beyond the end of its chunk";
    }
    std::string why;
    if (record.op == Op::message) {
      why = add_message(region.view, record, task, table, out);
    } else if (record.op == Op::schema || record.op == Op::channel) {
      why = describe(region.view, record, task, table);
    } else if (!may_be_skipped(record.op, region.in_chunk)) {
      why = fmt::format("a record of kind {} where messages are expected", static_cast<int>(record.op));
    }
    if (!why.empty()) return why;
  }
  return {};
}

std::string ChunkLoader::describe(ByteView& view, const Record& record, const Task& task, ChannelTable& table) const {
  if (task.learn) return learn_description(view, record, limits_, table);
  const auto compare = [&](const auto& found) { return table.compare(found); };
  return with_description(view, record, limits_, compare, compare);
}

std::string ChunkLoader::add_message(ByteView& view, const Record& record, const Task& task, const ChannelTable& table,
                                     LoadedChunk& out) {
  if (record.data_bytes < kMessageFields) return fmt::format("a message record has {} bytes", record.data_bytes);
  check_message_length(file_, record, limits_);
  const MessageHead head = parse_message_head(view.at(record.data_begin, kMessageFields));
  if (!table.contains(head.channel)) {
    return fmt::format("a message names channel {}, which does not exist", head.channel);
  }
  if (!head.time) return "a message has a time of 2^63 ns or more";
  ++out.messages;
  out.begin = std::min(out.begin, *head.time);
  out.end = std::max(out.end, *head.time);
  seen_.set(head.channel);
  const std::uint32_t id = head.channel;
  if (task.wanted != nullptr && !std::binary_search(task.wanted->begin(), task.wanted->end(), id)) return {};
  out.entries.push_back({*head.time, record.data_begin + kMessageFields,
                         static_cast<std::uint32_t>(record.data_bytes - kMessageFields), id});
  return {};
}

}  // namespace aslio::io::mcap
