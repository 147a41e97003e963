#include "io/mcap_fixture.hpp"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <stdexcept>

#include "aslio/core/errors.hpp"
#include "mcap/reader.hpp"

namespace aslio::io::test {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";

std::uint32_t crc_of(const ByteVector& bytes, std::size_t from = 0) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data() + from, bytes.size() - from));
}

ByteVector compressed(const std::string& compression, const ByteVector& in) {
  if (compression.empty()) return in;
  ByteVector out;
  std::size_t size = 0;
  if (compression == "zstd") {
    out.resize(ZSTD_compressBound(in.size()));
    size = ZSTD_compress(out.data(), out.size(), in.data(), in.size(), 1);
    if (ZSTD_isError(size)) throw std::runtime_error("zstd cannot compress");
  } else {
    out.resize(LZ4F_compressFrameBound(in.size(), nullptr));
    size = LZ4F_compressFrame(out.data(), out.size(), in.data(), in.size(), nullptr);
    if (LZ4F_isError(size)) throw std::runtime_error("lz4 cannot compress");
  }
  out.resize(size);
  return out;
}

ByteVector message(std::uint16_t channel, TimeNs time, const ByteVector& bytes) {
  Packed content;
  content.number(channel).number(std::uint32_t{0}).number(time).number(time).raw(bytes);
  return content.bytes();
}

}  // namespace

void append_record(ByteVector& out, std::uint8_t op, const ByteVector& content) {
  Packed head;
  head.number(op).number(static_cast<std::uint64_t>(content.size()));
  out.insert(out.end(), head.bytes().begin(), head.bytes().end());
  out.insert(out.end(), content.begin(), content.end());
}

Packed& Packed::text(std::string_view value) {
  number(static_cast<std::uint32_t>(value.size()));
  bytes_.insert(bytes_.end(), value.begin(), value.end());
  return *this;
}

Packed& Packed::raw(const ByteVector& value) {
  bytes_.insert(bytes_.end(), value.begin(), value.end());
  return *this;
}

Packed& Packed::map(const std::map<std::string, std::string>& value) {
  Packed entries;
  for (const auto& [key, text] : value) entries.text(key).text(text);
  return number(static_cast<std::uint32_t>(entries.bytes().size())).raw(entries.bytes());
}

McapWriter::McapWriter(McapOptions options) : options_(std::move(options)), file_(kMagic.begin(), kMagic.end()) {
  append_record(file_, 0x01, Packed().text("").text("test").bytes());
}

std::uint16_t McapWriter::add_schema(const std::string& name, const std::string& encoding, const std::string& data) {
  const std::uint16_t id = next_schema_++;
  const Packed content = Packed().number(id).text(name).text(encoding).text(data);
  append_record(place(), 0x03, content.bytes());
  append_record(schemas_, 0x03, content.bytes());
  return id;
}

std::uint16_t McapWriter::add_channel(const std::string& topic, std::uint16_t schema, const std::string& encoding,
                                      const std::map<std::string, std::string>& metadata) {
  const std::uint16_t id = next_channel_++;
  const Packed content = Packed().number(id).number(schema).text(topic).text(encoding).map(metadata);
  append_record(place(), 0x04, content.bytes());
  append_record(channels_, 0x04, content.bytes());
  return id;
}

void McapWriter::count(std::uint16_t channel, TimeNs time) {
  ++counts_[channel];
  begin_ = std::min(begin_, time);
  end_ = std::max(end_, time);
}

void McapWriter::write(std::uint16_t channel, TimeNs time, const ByteVector& bytes) {
  if (!options_.chunks) return write_outside(channel, time, bytes);
  count(channel, time);
  entries_[channel].emplace_back(time, chunk_.size());
  append_record(chunk_, 0x05, message(channel, time, bytes));
  if (chunk_.size() >= options_.chunk_bytes) end_chunk();
}

void McapWriter::write_outside(std::uint16_t channel, TimeNs time, const ByteVector& bytes) {
  count(channel, time);
  append_record(file_, 0x05, message(channel, time, bytes));
}

void McapWriter::add_record(std::uint8_t op, const ByteVector& content) {
  end_chunk();
  append_record(file_, op, content);
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  TimeNs begin = entries_.empty() ? 0 : kTimeMax, end = 0;
  for (const auto& [channel, times] : entries_) {
    for (const auto& [time, at] : times) {
      begin = std::min(begin, time);
      end = std::max(end, time);
    }
  }
  const Packed span = Packed().number(begin).number(end);
  const ByteVector packed = compressed(options_.compression, chunk_);
  const std::uint64_t position = file_.size(), declared = chunk_.size(), stored = packed.size();
  Packed content = span;
  content.number(declared).number(options_.crc ? crc_of(chunk_) : 0U).text(options_.compression);
  content.number(stored).raw(packed);
  append_record(file_, 0x06, content.bytes());
  const std::uint64_t behind = file_.size();
  const ByteVector offsets = add_message_indexes();
  Packed index = span;
  index.number(position).number(behind - position);
  index.number(static_cast<std::uint32_t>(offsets.size())).raw(offsets);
  index.number(file_.size() - behind).text(options_.compression).number(stored).number(declared);
  append_record(chunk_indexes_, 0x08, index.bytes());
  ++chunk_count_;
  chunk_.clear();
  entries_.clear();
}

ByteVector McapWriter::add_message_indexes() {
  Packed offsets;
  for (const auto& [channel, times] : entries_) {
    if (!options_.message_indexes) break;
    offsets.number(channel).number(file_.size());
    Packed places;
    for (const auto& [time, at] : times) places.number(time).number(at);
    Packed content;
    content.number(channel).number(static_cast<std::uint32_t>(places.bytes().size())).raw(places.bytes());
    append_record(file_, 0x07, content.bytes());
  }
  return offsets.bytes();
}

void McapWriter::add_summary() {
  for (const ByteVector* part : {&schemas_, &channels_, &chunk_indexes_}) {
    file_.insert(file_.end(), part->begin(), part->end());
  }
  std::uint64_t messages = 0;
  Packed counts;
  for (const auto& [channel, n] : counts_) {
    messages += n;
    counts.number(channel).number(n);
  }
  append_record(file_, 0x0B,
                Packed()
                    .number(messages)
                    .number(static_cast<std::uint16_t>(next_schema_ - 1))
                    .number(std::uint32_t{next_channel_})
                    .number(std::uint32_t{0})
                    .number(std::uint32_t{0})
                    .number(chunk_count_)
                    .number(counts_.empty() ? TimeNs{0} : begin_)
                    .number(counts_.empty() ? TimeNs{0} : end_)
                    .number(static_cast<std::uint32_t>(counts.bytes().size()))
                    .raw(counts.bytes())
                    .bytes());
}

const ByteVector& McapWriter::close() {
  end_chunk();
  append_record(file_, 0x0F, Packed().number(options_.crc ? crc_of(file_) : 0U).bytes());
  const std::uint64_t summary = file_.size();
  if (options_.summary) add_summary();
  const Packed head = Packed().number(std::uint8_t{0x02}).number(std::uint64_t{20});
  file_.insert(file_.end(), head.bytes().begin(), head.bytes().end());
  const Packed places = Packed().number(options_.summary ? summary : 0).number(std::uint64_t{0});
  file_.insert(file_.end(), places.bytes().begin(), places.bytes().end());
  const Packed crc = Packed().number(options_.crc ? crc_of(file_, static_cast<std::size_t>(summary)) : 0U);
  file_.insert(file_.end(), crc.bytes().begin(), crc.bytes().end());
  file_.insert(file_.end(), kMagic.begin(), kMagic.end());
  return file_;
}

ByteVector small_mcap(const McapOptions& options, int count) {
  McapWriter writer(options);
  const std::uint16_t schema = writer.add_schema("std_msgs/String", "ros1msg", "string data\n");
  const std::uint16_t a = writer.add_channel("/a", schema, "ros1", {{"md5sum", "5a"}});
  const std::uint16_t b = writer.add_channel("/b", schema, "ros1");
  for (int i = 0; i < count; ++i) {
    ByteVector bytes(static_cast<std::size_t>(3 + i % 7), static_cast<std::uint8_t>(i));
    bytes[1] = static_cast<std::uint8_t>(i >> 8);
    writer.write(i % 2 == 0 ? a : b, 1000 + 10 * i, bytes);
  }
  return writer.close();
}

std::vector<Read> read_messages(MessageReader& reader) {
  std::vector<Read> out;
  RawMessage message;
  while (reader.next(message)) {
    out.push_back({message.connection, message.time, ByteVector(message.bytes.begin(), message.bytes.end())});
  }
  return out;
}

ReadFile read_mcap(const std::filesystem::path& path) {
  ReadFile file;
  try {
    mcap::McapReader reader(path);
    try {
      RawMessage message;
      while (reader.next(message)) {
        file.messages.push_back(
            {message.connection, message.time, ByteVector(message.bytes.begin(), message.bytes.end())});
      }
    } catch (const DataError& error) {
      file.refusal = error.what();
    }
    file.status = reader.status();
    file.warnings = reader.warnings();
  } catch (const DataError& error) {
    file.refusal = error.what();
  }
  return file;
}

}  // namespace aslio::io::test
