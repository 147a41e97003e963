#include "aslio/io/mcap/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "../compress.hpp"
#include "../rosbag/format.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "checksum.hpp"

namespace aslio::io::mcap {
namespace {

using rosbag::append;
using rosbag::append_text;
using Buffer = std::vector<std::uint8_t>;

void put_text(Buffer& out, std::string_view text) {
  append(out, static_cast<std::uint32_t>(text.size()));
  append_text(out, text);
}

void put_sized(Buffer& out, const Buffer& bytes) {
  append(out, static_cast<std::uint32_t>(bytes.size()));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void put_record(Buffer& out, Op op, const Buffer& content) {
  append(out, op);
  append(out, static_cast<std::uint64_t>(content.size()));
  out.insert(out.end(), content.begin(), content.end());
}

struct WrittenChannel {
  Buffer schema, channel;  ///< their records
  std::uint32_t sequence = 0;
  std::uint64_t messages = 0;
  bool described = false;  ///< its records stand before its first message
};

std::string_view name_of(Compression compression) {
  return compression == Compression::lz4 ? "lz4" : compression == Compression::zstd ? "zstd" : "";
}

/// The profile of a file whose channels are all of one kind.
std::string_view profile_of(bool ros1, bool cdr) { return ros1 == cdr ? "" : ros1 ? "ros1" : "ros2"; }

std::string_view as_text(const Buffer& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

struct McapWriter::Impl {
  AtomicFile file;
  WriterOptions options;
  std::vector<WrittenChannel> channels;
  Buffer chunk;                                                                    ///< open, uncompressed
  std::map<std::uint16_t, std::vector<std::pair<TimeNs, std::uint64_t>>> entries;  ///< of the open chunk
  Buffer chunk_indexes;
  std::uint32_t chunks = 0, crc = 0;
  TimeNs begin = kTimeMax, end = kTimeMin;
  bool ros1 = false, cdr = false, begun = false;
  std::uint64_t messages = 0;

  Impl(const std::filesystem::path& path, WriterOptions opts) : file(path, true), options(opts) {}

  void write(const Buffer& bytes) {
    file.write(as_text(bytes));
    crc = crc32_of(bytes, crc);
  }

  /// Magic and header, which names the profile: that is known with the channels.
  void begin_file() {
    if (std::exchange(begun, true)) return;
    Buffer out, content;
    append_text(out, kMagic);
    put_text(content, profile_of(ros1, cdr));
    put_text(content, "aslio");
    put_record(out, Op::header, content);
    write(out);
  }

  void end_chunk() {
    if (chunk.empty()) return;
    begin_file();
    TimeNs first = kTimeMax, last = kTimeMin;
    for (const auto& [channel, places] : entries) {
      for (const auto& [time, at] : places) {
        first = std::min(first, time);
        last = std::max(last, time);
      }
    }
    const bool none = options.compression == Compression::none, lz4 = options.compression == Compression::lz4;
    const Buffer packed = none ? chunk : lz4 ? compress_lz4(chunk) : compress_zstd(chunk);
    Buffer content, record;
    append(content, first);
    append(content, last);
    append(content, static_cast<std::uint64_t>(chunk.size()));
    append(content, crc32_of(chunk));
    put_text(content, name_of(options.compression));
    append(content, static_cast<std::uint64_t>(packed.size()));
    content.insert(content.end(), packed.begin(), packed.end());
    const std::uint64_t position = file.position();
    put_record(record, Op::chunk, content);
    write(record);
    const std::uint64_t behind = file.position();
    const Buffer offsets = write_message_indexes();
    Buffer index;
    append(index, first);
    append(index, last);
    append(index, position);
    append(index, behind - position);
    put_sized(index, offsets);
    append(index, file.position() - behind);
    put_text(index, name_of(options.compression));
    append(index, static_cast<std::uint64_t>(packed.size()));
    append(index, static_cast<std::uint64_t>(chunk.size()));
    put_record(chunk_indexes, Op::chunk_index, index);
    ++chunks;
    begin = std::min(begin, first);
    end = std::max(end, last);
    chunk.clear();
    entries.clear();
  }

  /// Returns the map of channels and places for the index of the chunk.
  Buffer write_message_indexes() {
    Buffer offsets;
    for (const auto& [channel, places] : entries) {
      append(offsets, channel);
      append(offsets, file.position());
      Buffer list, content, record;
      for (const auto& [time, at] : places) {
        append(list, time);
        append(list, at);
      }
      append(content, channel);
      put_sized(content, list);
      put_record(record, Op::message_index, content);
      write(record);
    }
    return offsets;
  }

  Buffer statistics() const {
    Buffer content, counts;
    for (std::size_t id = 0; id < channels.size(); ++id) {
      append(counts, static_cast<std::uint16_t>(id));
      append(counts, channels[id].messages);
    }
    append(content, messages);
    append(content, static_cast<std::uint16_t>(channels.size()));  // schemas: each channel has its own
    append(content, static_cast<std::uint32_t>(channels.size()));
    append(content, std::uint32_t{0});  // attachments
    append(content, std::uint32_t{0});  // metadata
    append(content, chunks);
    append(content, messages == 0 ? TimeNs{0} : begin);
    append(content, messages == 0 ? TimeNs{0} : end);
    put_sized(content, counts);
    Buffer record;
    put_record(record, Op::statistics, content);
    return record;
  }

  /// Summary, its offsets and the footer. Checksums begin with the summary.
  void write_summary() {
    const std::uint64_t summary = file.position();
    Buffer schemas, described;
    for (const WrittenChannel& channel : channels) {
      schemas.insert(schemas.end(), channel.schema.begin(), channel.schema.end());
      described.insert(described.end(), channel.channel.begin(), channel.channel.end());
    }
    const Buffer statistics_record = statistics();
    Buffer out, offsets;
    for (const auto& [op, group] : {std::pair<Op, const Buffer&>{Op::schema, schemas},
                                    {Op::channel, described},
                                    {Op::statistics, statistics_record},
                                    {Op::chunk_index, chunk_indexes}}) {
      if (group.empty()) continue;
      Buffer content;
      append(content, op);
      append(content, summary + out.size());
      append(content, static_cast<std::uint64_t>(group.size()));
      put_record(offsets, Op::summary_offset, content);
      out.insert(out.end(), group.begin(), group.end());
    }
    const std::uint64_t offsets_begin = summary + out.size();
    out.insert(out.end(), offsets.begin(), offsets.end());
    append(out, Op::footer);
    append(out, kFooterBytes);
    append(out, summary);
    append(out, offsets_begin);
    append(out, crc32_of(out));
    append_text(out, kMagic);
    file.write(as_text(out));
  }
};

McapWriter::McapWriter(const std::filesystem::path& path, WriterOptions options)
    : impl_(std::make_unique<Impl>(path, options)) {}

McapWriter::~McapWriter() = default;

std::uint32_t McapWriter::add(const Connection& connection) {
  Impl& w = *impl_;
  constexpr std::size_t kMost = 0xFFFE;  // ids of schemas begin with 1
  const std::size_t id = w.channels.size();
  if (connection.encoding == Encoding::other || id >= kMost) {
    throw DataError(fmt::format("{}: cannot take the topic {}: {}", w.file.path().string(), connection.topic,
                                id >= kMost ? "a file holds 65534 channels" : "its messages are none of ROS1 or ROS2"));
  }
  const bool ros1 = connection.encoding == Encoding::ros1;
  (ros1 ? w.ros1 : w.cdr) = true;
  const auto schema_id = static_cast<std::uint16_t>(id + 1);
  WrittenChannel& written = w.channels.emplace_back();
  Buffer content;
  append(content, schema_id);
  put_text(content, connection.type);
  put_text(content, ros1 ? "ros1msg" : "ros2msg");
  put_text(content, connection.definition);
  put_record(written.schema, Op::schema, content);
  content.clear();
  append(content, static_cast<std::uint16_t>(id));
  append(content, schema_id);
  put_text(content, connection.topic);
  put_text(content, ros1 ? "ros1" : "cdr");
  Buffer metadata;
  if (!connection.md5.empty()) {
    put_text(metadata, "md5sum");
    put_text(metadata, connection.md5);
  }
  put_sized(content, metadata);
  put_record(written.channel, Op::channel, content);
  return static_cast<std::uint32_t>(id);
}

void McapWriter::write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) {
  Impl& w = *impl_;
  if (connection >= w.channels.size() || time < 0) {
    throw DataError(fmt::format("{}: cannot write a message of channel {} at {} ns: {}", w.file.path().string(),
                                connection, time, time < 0 ? "times begin at 0" : "there is no such channel"));
  }
  WrittenChannel& channel = w.channels[connection];
  if (!std::exchange(channel.described, true)) {
    w.chunk.insert(w.chunk.end(), channel.schema.begin(), channel.schema.end());
    w.chunk.insert(w.chunk.end(), channel.channel.begin(), channel.channel.end());
  }
  const auto id = static_cast<std::uint16_t>(connection);
  w.entries[id].emplace_back(time, w.chunk.size());
  append(w.chunk, Op::message);
  append(w.chunk, kMessageFields + bytes.size());
  append(w.chunk, id);
  append(w.chunk, channel.sequence++);
  append(w.chunk, time);  // logged
  append(w.chunk, time);  // published
  w.chunk.insert(w.chunk.end(), bytes.begin(), bytes.end());
  ++channel.messages;
  ++w.messages;
  if (w.chunk.size() >= w.options.chunk_bytes) w.end_chunk();
}

void McapWriter::close() {
  Impl& w = *impl_;
  w.begin_file();
  w.end_chunk();
  Buffer content, record;
  append(content, w.crc);
  put_record(record, Op::data_end, content);
  w.file.write(as_text(record));
  w.write_summary();
  w.file.close();
}

}  // namespace aslio::io::mcap
