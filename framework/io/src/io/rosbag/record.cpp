#include "record.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace aslio::io::rosbag {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::string_view text(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// Names from a file reach terminals and reports: control characters in them are replaced.
std::string name_text(Bytes bytes) {
  std::string name(text(bytes));
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return name;
}

/// Calls `take(name, value)` for each `name=value` of a header; returns what is wrong.
template <class Take>
std::string each_field(Bytes header, Take&& take) {
  while (!header.empty()) {
    if (header.size() < 4) return "its header ends inside a field length";
    const std::uint32_t length = load<std::uint32_t>(header.data());
    header = header.subspan(4);
    if (length > header.size()) {
      return fmt::format("a header field claims {} bytes where {} are left", length, header.size());
    }
    const std::string_view field = text(header.first(length));
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) return "a header field has no '='";
    if (!take(field.substr(0, equals), header.subspan(equals + 1, length - equals - 1))) {
      return fmt::format("header field '{}' has {} bytes", field.substr(0, std::min<std::size_t>(equals, 32)),
                         length - equals - 1);
    }
    header = header.subspan(length);
  }
  return {};
}

template <class T>
bool number(Bytes value, std::optional<T>& to) {
  if (value.size() != sizeof(T)) return false;
  to = load<T>(value.data());
  return true;
}

bool time(Bytes value, std::optional<TimeNs>& to) {
  if (value.size() != 8) return false;
  to = load_time(value.data());
  return true;
}

/// False when a known field has the wrong size; unknown fields are permitted by the format.
bool take_field(std::string_view name, Bytes value, Record& record, std::optional<std::uint8_t>& op) {
  if (name == "op") return number(value, op);
  if (name == "conn") return number(value, record.connection);
  if (name == "time") return time(value, record.time);
  if (name == "count") return number(value, record.count);
  if (name == "size") return number(value, record.size);
  if (name == "ver") return number(value, record.version);
  if (name == "conn_count") return number(value, record.connection_count);
  if (name == "chunk_count") return number(value, record.chunk_count);
  if (name == "index_pos") return number(value, record.index_position);
  if (name == "chunk_pos") return number(value, record.chunk_position);
  if (name == "start_time") return time(value, record.begin);
  if (name == "end_time") return time(value, record.end);
  if (name == "compression") record.compression = name_text(value);
  if (name == "topic") record.topic = name_text(value);
  if (name == "encryptor") record.encryptor = text(value);
  return true;
}

}  // namespace

Parsed parse_record(ByteView& view, std::uint64_t position, std::uint64_t end, const Limits& limits, Record& record,
                    std::string& why) {
  record = Record{};
  if (position > end || end - position < 4) return Parsed::header_cut;
  const std::uint64_t header_bytes = load<std::uint32_t>(view.at(position, 4));
  if (header_bytes > limits.header_bytes) {
    why = fmt::format("its header claims {} bytes (at most {})", header_bytes, limits.header_bytes);
    return Parsed::damaged;
  }
  if (end - position < 8 + header_bytes) return Parsed::header_cut;
  const std::uint8_t* start = view.at(position + 4, static_cast<std::size_t>(header_bytes) + 4);
  std::optional<std::uint8_t> op;
  why = each_field({start, static_cast<std::size_t>(header_bytes)},
                   [&](std::string_view name, Bytes value) { return take_field(name, value, record, op); });
  if (!why.empty()) return Parsed::damaged;
  if (!op) {
    why = "its header has no 'op'";
    return Parsed::damaged;
  }
  record.op = static_cast<Op>(*op);
  record.data_begin = position + 8 + header_bytes;
  record.data_bytes = load<std::uint32_t>(start + header_bytes);
  if (record.data_bytes > limits.record_bytes) {
    why = fmt::format("it claims {} bytes of data (at most {})", record.data_bytes, limits.record_bytes);
    return Parsed::damaged;
  }
  return record.next() > end ? Parsed::data_cut : Parsed::ok;
}

std::string parse_connection(ByteView& view, const Record& record, const Limits& limits, Connection& connection) {
  if (!record.connection) return "a connection record has no 'conn'";
  if (record.data_bytes > limits.header_bytes) {
    return fmt::format("a connection description claims {} bytes (at most {})", record.data_bytes, limits.header_bytes);
  }
  connection = Connection{*record.connection, record.topic, {}, {}, {}};
  const Bytes data{view.at(record.data_begin, static_cast<std::size_t>(record.data_bytes)),
                   static_cast<std::size_t>(record.data_bytes)};
  return each_field(data, [&](std::string_view name, Bytes value) {
    if (name == "type") connection.type = name_text(value);
    if (name == "md5sum") connection.md5 = name_text(value);
    if (name == "message_definition") connection.definition = text(value);
    return true;
  });
}

}  // namespace aslio::io::rosbag
