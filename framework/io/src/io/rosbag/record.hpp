#pragma once
/// One record of a bag: its header fields, and where its data lies.

#include <optional>
#include <string>

#include "../input_file.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "format.hpp"

namespace aslio::io::rosbag {

struct Record {
  Op op{};
  std::optional<std::uint32_t> connection, count, size, version, connection_count, chunk_count;
  std::optional<std::uint64_t> index_position, chunk_position;
  std::optional<TimeNs> time, begin, end;
  std::string compression, topic, encryptor;
  std::uint64_t data_begin = 0, data_bytes = 0;
  std::uint64_t next() const { return data_begin + data_bytes; }
};

enum class Parsed : std::uint8_t {
  ok,
  data_cut,    ///< the header is whole, its data reach beyond the end
  header_cut,  ///< not even the header is whole
  damaged      ///< `why` says how
};

/// Reads the record at `position` of a region that ends at `end`. Never reads or allocates beyond it.
Parsed parse_record(ByteView& view, std::uint64_t position, std::uint64_t end, const Limits& limits, Record& record,
                    std::string& why);

/// Reads the description in a connection record. Empty text on success, otherwise what is wrong.
std::string parse_connection(ByteView& view, const Record& record, const Limits& limits, Connection& connection);

}  // namespace aslio::io::rosbag
