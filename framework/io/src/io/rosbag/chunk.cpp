#include "chunk.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "../decompress.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::io::rosbag {
namespace {

auto position_of(const std::vector<Connection>& all, std::uint32_t id) {
  return std::lower_bound(all.begin(), all.end(), id, [](const Connection& c, std::uint32_t i) { return c.id < i; });
}

}  // namespace

std::string ConnectionTable::add(Connection connection, std::size_t limit) {
  const auto at = position_of(all_, connection.id);
  if (at != all_.end() && at->id == connection.id) {
    if (at->topic == connection.topic && at->type == connection.type && at->md5 == connection.md5) return {};
    return fmt::format("connection {} is described twice, with different content", connection.id);
  }
  if (all_.size() >= limit) return fmt::format("it has more than {} connections", limit);
  all_.insert(at, std::move(connection));
  return {};
}

bool ConnectionTable::contains(std::uint32_t id) const {
  const auto at = position_of(all_, id);
  return at != all_.end() && at->id == id;
}

void ChunkLoader::damaged(std::uint64_t position, const std::string& why) const {
  throw DataError(
      fmt::format("{}: damaged chunk at offset {}: {}; copy the bag again from its origin, or cut it before "
                  "this offset",
                  file_.path().string(), position, why));
}

void ChunkLoader::decompress_into(std::uint64_t position, const Record& chunk, bool may_be_cut, LoadedChunk& out) {
  const bool lz4 = chunk.compression == "lz4";
  if (!lz4 && chunk.compression != "bz2") {
    damaged(position, fmt::format("unknown compression '{}' (none, lz4 and bz2 are known)",
                                  std::string_view(chunk.compression).substr(0, 32)));
  }
  const std::uint64_t declared = chunk.size.value_or(0);
  if (declared > limits_.chunk_bytes) {
    throw DataError(fmt::format(
        "{}: the chunk at offset {} decompresses to {} bytes, where at most {} are read at once; write the bag "
        "with smaller chunks: `rosbag filter IN.bag OUT.bag True`",
        file_.path().string(), position, declared, limits_.chunk_bytes));
  }
  const std::uint64_t ratio = lz4 ? limits_.lz4_ratio : limits_.bz2_ratio;
  if (declared > ratio * std::max<std::uint64_t>(chunk.data_bytes, 1)) {
    damaged(position, fmt::format("{} bytes claim to decompress to {} (at most {} times as many)", chunk.data_bytes,
                                  declared, ratio));
  }
  // Incompressible data grow a little; far more than the content is no honest chunk.
  if (chunk.data_bytes > declared + declared / 4 + 4096) {
    damaged(position, fmt::format("{} compressed bytes for {} decompressed ones", chunk.data_bytes, declared));
  }
  const std::uint64_t present = std::min(chunk.data_bytes, file_.size() - chunk.data_begin);
  compressed_.resize(static_cast<std::size_t>(present));
  file_.read(chunk.data_begin, compressed_);
  const std::string why = decompress(lz4 ? ChunkCoding::lz4 : ChunkCoding::bz2, compressed_,
                                     static_cast<std::size_t>(declared), out.memory);
  if (!why.empty() && !(out.cut && may_be_cut)) damaged(position, why);
  out.in_memory = true;
}

std::string ChunkLoader::list(ByteView& view, std::uint64_t begin, std::uint64_t end,
                              const std::vector<std::uint32_t>* wanted, ConnectionTable& known, bool learn,
                              LoadedChunk& out) {
  Record record;
  std::string why;
  for (std::uint64_t position = begin; position < end; position = record.next()) {
    switch (parse_record(view, position, end, limits_, record, why)) {
      case Parsed::ok:
        break;
      case Parsed::damaged:
        return why;
      case Parsed::header_cut:
      case Parsed::data_cut:
        return out.cut ? std::string{} : "a record reaches beyond the end of its chunk";
    }
    if (record.op == Op::connection) {
      if (!learn) continue;
      Connection connection;
      why = parse_connection(view, record, limits_, connection);
      if (why.empty()) why = known.add(std::move(connection), limits_.connections);
      if (!why.empty()) return why;
    } else if (record.op == Op::message) {
      if (!record.connection || !record.time) return "a message record has no connection or no time";
      const std::uint32_t id = *record.connection;
      if (!known.contains(id)) return fmt::format("a message names connection {}, which does not exist", id);
      ++out.messages;
      out.begin = std::min(out.begin, *record.time);
      out.end = std::max(out.end, *record.time);
      if (wanted != nullptr && !std::binary_search(wanted->begin(), wanted->end(), id)) continue;
      out.entries.push_back({*record.time, record.data_begin, static_cast<std::uint32_t>(record.data_bytes), id});
    } else {
      return fmt::format("a record of kind {} where messages are expected", static_cast<int>(record.op));
    }
  }
  return {};
}

void ChunkLoader::load(std::uint64_t position, bool may_be_cut, const std::vector<std::uint32_t>* wanted,
                       ConnectionTable& known, bool learn, LoadedChunk& out) {
  out.start_over(position);
  Record chunk;
  std::string why;
  const Parsed parsed = parse_record(view_, position, file_.size(), limits_, chunk, why);
  out.cut = parsed == Parsed::data_cut || parsed == Parsed::header_cut;
  if (parsed == Parsed::damaged) damaged(position, why);
  if (out.cut && !may_be_cut) damaged(position, "the file ends inside it");
  if (parsed == Parsed::header_cut) return;
  if (chunk.op != Op::chunk || !chunk.size) damaged(position, "no chunk stands there");
  if (chunk.compression == "none") {
    if (*chunk.size != chunk.data_bytes) {
      damaged(position, fmt::format("it declares {} bytes and holds {}", *chunk.size, chunk.data_bytes));
    }
    const std::uint64_t end = std::min(chunk.next(), file_.size());
    why = list(view_, chunk.data_begin, end, wanted, known, learn, out);
  } else {
    decompress_into(position, chunk, may_be_cut, out);
    ByteView memory{out.memory.bytes()};
    why = list(memory, 0, out.memory.size(), wanted, known, learn, out);
  }
  if (!why.empty()) damaged(position, why);
  out.put_in_order();
}

}  // namespace aslio::io::rosbag
