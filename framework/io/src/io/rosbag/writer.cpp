#include "aslio/io/rosbag/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "../compress.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "format.hpp"

namespace aslio::io::rosbag {
namespace {

using Buffer = std::vector<std::uint8_t>;

struct WrittenConnection {
  std::string topic, type, md5, definition;
  bool in_chunk = false;  ///< its record stands before its first message
};

struct IndexEntry {
  TimeNs time;
  std::uint32_t offset;
};

struct WrittenChunk {
  std::uint64_t position = 0;
  TimeNs begin = 0, end = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> counts;  ///< connection, messages
};

template <class T>
void field(Buffer& header, std::string_view name, const T& value) {
  append(header, static_cast<std::uint32_t>(name.size() + 1 + sizeof(T)));
  append_text(header, name);
  header.push_back('=');
  append(header, value);
}

void text_field(Buffer& header, std::string_view name, std::string_view value) {
  append(header, static_cast<std::uint32_t>(name.size() + 1 + value.size()));
  append_text(header, name);
  header.push_back('=');
  append_text(header, value);
}

void time_field(Buffer& header, std::string_view name, TimeNs t) {
  append(header, static_cast<std::uint32_t>(name.size() + 1 + 8));
  append_text(header, name);
  header.push_back('=');
  append_time(header, t);
}

void append_record(Buffer& out, const Buffer& header, std::span<const std::uint8_t> data) {
  append(out, static_cast<std::uint32_t>(header.size()));
  out.insert(out.end(), header.begin(), header.end());
  append(out, static_cast<std::uint32_t>(data.size()));
  out.insert(out.end(), data.begin(), data.end());
}

Buffer connection_record(std::uint32_t id, const WrittenConnection& connection) {
  Buffer header, data, record;
  field(header, "op", Op::connection);
  field(header, "conn", id);
  text_field(header, "topic", connection.topic);
  text_field(data, "topic", connection.topic);
  text_field(data, "type", connection.type);
  text_field(data, "md5sum", connection.md5);
  text_field(data, "message_definition", connection.definition);
  append_record(record, header, data);
  return record;
}

Buffer file_header(std::uint64_t index_position, std::size_t connections, std::size_t chunks) {
  Buffer header, record;
  field(header, "op", Op::bag_header);
  field(header, "index_pos", index_position);
  field(header, "conn_count", static_cast<std::uint32_t>(connections));
  field(header, "chunk_count", static_cast<std::uint32_t>(chunks));
  append_record(record, header, Buffer(kFileHeaderBytes - 8 - header.size(), ' '));
  return record;
}

std::string_view as_text(const Buffer& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

struct BagWriter::Impl {
  AtomicFile file;
  WriterOptions options;
  std::vector<WrittenConnection> connections;
  std::vector<WrittenChunk> chunks;
  Buffer chunk;  ///< open chunk, uncompressed
  std::map<std::uint32_t, std::vector<IndexEntry>> index;
  Buffer scratch;

  Impl(const std::filesystem::path& path, WriterOptions opts) : file(path, true), options(opts) {
    file.write(kMagic);
    file.write(as_text(file_header(0, 0, 0)));
  }

  void flush_chunk() {
    if (chunk.empty()) return;
    WrittenChunk info{file.position(), kTimeMax, kTimeMin, {}};
    const bool lz4 = options.compression == Compression::lz4;
    Buffer header, record;
    field(header, "op", Op::chunk);
    text_field(header, "compression", lz4 ? "lz4" : "none");
    field(header, "size", static_cast<std::uint32_t>(chunk.size()));
    append_record(record, header, lz4 ? compress_lz4(chunk) : chunk);
    for (const auto& [id, entries] : index) {
      Buffer index_header, data;
      field(index_header, "op", Op::index_data);
      field(index_header, "ver", std::uint32_t{1});
      field(index_header, "conn", id);
      field(index_header, "count", static_cast<std::uint32_t>(entries.size()));
      for (const IndexEntry& entry : entries) {
        append_time(data, entry.time);
        append(data, entry.offset);
        info.begin = std::min(info.begin, entry.time);
        info.end = std::max(info.end, entry.time);
      }
      append_record(record, index_header, data);
      info.counts.emplace_back(id, static_cast<std::uint32_t>(entries.size()));
    }
    file.write(as_text(record));
    chunks.push_back(std::move(info));
    chunk.clear();
    index.clear();
  }

  void write_index() {
    const std::uint64_t index_position = file.position();
    for (std::size_t id = 0; id < connections.size(); ++id) {
      file.write(as_text(connection_record(static_cast<std::uint32_t>(id), connections[id])));
    }
    for (const WrittenChunk& info : chunks) {
      Buffer header, data, record;
      field(header, "op", Op::chunk_info);
      field(header, "ver", std::uint32_t{1});
      field(header, "chunk_pos", info.position);
      time_field(header, "start_time", info.begin);
      time_field(header, "end_time", info.end);
      field(header, "count", static_cast<std::uint32_t>(info.counts.size()));
      for (const auto& [id, count] : info.counts) {
        append(data, id);
        append(data, count);
      }
      append_record(record, header, data);
      file.write(as_text(record));
    }
    file.patch(kMagic.size(), as_text(file_header(index_position, connections.size(), chunks.size())));
  }
};

BagWriter::BagWriter(const std::filesystem::path& path, WriterOptions options)
    : impl_(std::make_unique<Impl>(path, options)) {}

BagWriter::~BagWriter() = default;

std::uint32_t BagWriter::add_connection(const std::string& topic, const std::string& type, const std::string& md5,
                                        const std::string& definition) {
  impl_->connections.push_back({topic, type, md5, definition});
  return static_cast<std::uint32_t>(impl_->connections.size() - 1);
}

std::uint32_t BagWriter::add(const Connection& connection) {
  if (connection.encoding != Encoding::ros1) {
    throw DataError(fmt::format("{}: a ROS1 bag carries ROS1 messages, and those of {} are none",
                                impl_->file.path().string(), connection.topic));
  }
  return add_connection(connection.topic, connection.type, connection.md5, connection.definition);
}

void BagWriter::write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) {
  Impl& w = *impl_;
  constexpr TimeNs kLastTime = (TimeNs{1} << 32) * kSecond - 1;
  if (connection >= w.connections.size() || time < 0 || time > kLastTime) {
    throw DataError(fmt::format(
        "{}: cannot write a message of connection {} at {} ns: {}", w.file.path().string(), connection, time,
        connection >= w.connections.size() ? "no such connection" : "a bag holds times from 0 to 2^32 s"));
  }
  WrittenConnection& written = w.connections[connection];
  if (!written.in_chunk) {
    const Buffer record = connection_record(connection, written);
    w.chunk.insert(w.chunk.end(), record.begin(), record.end());
    written.in_chunk = true;
  }
  w.index[connection].push_back({time, static_cast<std::uint32_t>(w.chunk.size())});
  Buffer& header = w.scratch;
  header.clear();
  field(header, "op", Op::message);
  field(header, "conn", connection);
  time_field(header, "time", time);
  append_record(w.chunk, header, bytes);
  if (w.chunk.size() >= w.options.chunk_bytes) w.flush_chunk();
}

void BagWriter::close() {
  impl_->flush_chunk();
  if (impl_->options.index) impl_->write_index();
  impl_->file.close();
}

}  // namespace aslio::io::rosbag
