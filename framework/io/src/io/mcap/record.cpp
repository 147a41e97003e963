#include "record.hpp"

#include <algorithm>

namespace aslio::io::mcap {
namespace {

/// Names from a file reach terminals and reports: control characters in them are replaced.
std::string printable(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return name;
}

std::optional<TimeNs> time_of(std::uint64_t nanoseconds) {
  if (nanoseconds > static_cast<std::uint64_t>(kTimeMax)) return std::nullopt;
  return static_cast<TimeNs>(nanoseconds);
}

}  // namespace

Parsed parse_record(ByteView& view, std::uint64_t position, std::uint64_t end, Record& record) {
  record = Record{};
  record.position = position;
  if (position > end || end - position < kHeadBytes) return Parsed::head_cut;
  const std::uint8_t* head = view.at(position, kHeadBytes);
  record.op = static_cast<Op>(head[0]);
  record.data_begin = position + kHeadBytes;
  std::memcpy(&record.data_bytes, head + 1, sizeof record.data_bytes);
  if (head[0] == 0) return Parsed::no_record;
  return record.data_bytes > end - record.data_begin ? Parsed::data_cut : Parsed::ok;
}

Bytes Fields::bytes(std::uint64_t count) {
  if (count > rest_.size()) {
    whole_ = false;
    rest_ = {};
    return {};
  }
  const Bytes taken = rest_.first(static_cast<std::size_t>(count));
  rest_ = rest_.subspan(static_cast<std::size_t>(count));
  return taken;
}

std::string Fields::text() {
  const Bytes taken = sized();
  return {taken.begin(), taken.end()};
}

TimeNs Fields::time() {
  const std::optional<TimeNs> t = time_of(number<std::uint64_t>());
  whole_ = whole_ && t;
  return t.value_or(0);
}

std::optional<Schema> parse_schema(Bytes content) {
  Fields fields(content);
  Schema schema;
  schema.id = fields.number<std::uint16_t>();
  schema.name = printable(fields.text());
  schema.encoding = fields.text();
  schema.data = fields.text();
  if (!fields.whole()) return std::nullopt;
  return schema;
}

std::optional<Channel> parse_channel(Bytes content) {
  Fields fields(content);
  Channel channel;
  channel.id = fields.number<std::uint16_t>();
  channel.schema = fields.number<std::uint16_t>();
  channel.topic = printable(fields.text());
  channel.encoding = fields.text();
  Fields entries(fields.sized());
  while (!entries.empty()) {
    std::string key = entries.text();
    channel.metadata[std::move(key)] = printable(entries.text());
  }
  if (!fields.whole() || !entries.whole()) return std::nullopt;
  return channel;
}

std::optional<ChunkIndex> parse_chunk_index(Bytes content) {
  Fields fields(content);
  ChunkIndex index;
  index.begin = fields.time();
  index.end = fields.time();
  index.position = fields.number<std::uint64_t>();
  index.bytes = fields.number<std::uint64_t>();
  Fields offsets(fields.sized());
  while (!offsets.empty()) {
    index.channels.push_back(offsets.number<std::uint16_t>());
    offsets.number<std::uint64_t>();
  }
  index.index_bytes = fields.number<std::uint64_t>();
  if (!fields.whole() || !offsets.whole()) return std::nullopt;
  std::sort(index.channels.begin(), index.channels.end());
  return index;
}

std::optional<Footer> parse_footer(Bytes content) {
  Fields fields(content);
  Footer footer;
  footer.summary_begin = fields.number<std::uint64_t>();
  fields.number<std::uint64_t>();
  footer.summary_crc = fields.number<std::uint32_t>();
  if (!fields.whole()) return std::nullopt;
  return footer;
}

std::optional<ChunkHead> parse_chunk_head(ByteView& view, const Record& record) {
  constexpr std::uint64_t kLongest = 128;  // all fields in front of the data, with a long name of the compression
  const std::uint64_t there = std::min({kLongest, record.data_bytes, view.size() - record.data_begin});
  const Bytes content{view.at(record.data_begin, static_cast<std::size_t>(there)), static_cast<std::size_t>(there)};
  Fields fields(content);
  ChunkHead head;
  head.begin = fields.time();
  head.end = fields.time();
  head.declared = fields.number<std::uint64_t>();
  head.crc = fields.number<std::uint32_t>();
  const Bytes compression = fields.sized();
  head.compression.assign(compression.begin(), compression.end());
  head.data_bytes = fields.number<std::uint64_t>();
  if (!fields.whole()) return std::nullopt;
  const std::uint64_t front = 40 + compression.size();
  if (head.data_bytes > record.data_bytes - front) return std::nullopt;
  head.data_begin = record.data_begin + front;
  return head;
}

MessageHead parse_message_head(const std::uint8_t* from) {
  MessageHead head;
  std::uint64_t time = 0;
  std::memcpy(&head.channel, from, sizeof head.channel);
  std::memcpy(&time, from + 6, sizeof time);
  head.time = time_of(time);
  return head;
}

}  // namespace aslio::io::mcap
