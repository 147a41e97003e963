#pragma once
/// What a file says about its channels and chunks, from its summary or from a scan.

#include "chunk.hpp"

namespace aslio::io::mcap {

/// Where the parts of a file lie.
struct Frame {
  std::uint64_t first_record = 0;  ///< behind the header
  std::uint64_t end = 0;           ///< of all records but the footer
  bool closed = false;             ///< it ends as it should
  Footer footer;
};

struct Index {
  ChannelTable channels;
  std::vector<ChunkInfo> chunks;  ///< and runs of messages outside chunks; in the order of sort_chunks()
  std::map<std::uint32_t, std::uint64_t> counts;  ///< messages by channel, from the statistics; empty: not told
  DataChecksum checksum;
  InputStatus status = InputStatus::complete;
  std::vector<std::string> warnings;
  bool by_content = false;  ///< all chunks were looked into
};

Index read_index(const InputFile& file, const Limits& limits);

/// The index by the messages of a file whose own is not to be believed: `why`, for a warning.
Index scan_content(const InputFile& file, const Limits& limits, const std::string& why);

}  // namespace aslio::io::mcap
