#pragma once
/// Poses as they are read, and what becomes of them.

#include <string>
#include <vector>

#include "aslio/io/reference.hpp"

namespace aslio::io {

/// A pose and where it stands: line of a file, or number of a message.
struct ReferenceRow {
  StampedPose pose;
  std::size_t line = 0;
};

struct ReferenceRows {
  std::vector<ReferenceRow> rows;
  std::string source;           ///< file, or file and topic
  const char* place = "line";   ///< what ReferenceRow::line counts
  bool positions_only = false;  ///< no orientation is written
  std::vector<std::string> notes, warnings;
};

/// More poses than any recording has; beyond, memory is not bounded.
inline constexpr std::size_t kMostPoses = 10'000'000;

ReferenceRows read_text_rows(const ReferenceSpec& spec);
ReferenceRows read_message_rows(const ReferenceSpec& spec);

/// Whether the file is one of messages: by its first bytes, or by what is in the folder.
bool is_recording(const std::string& path);

/// In order, each stamp once, with offset and spacing; what was wrong is told. Throws DataError for stamps of too few
/// digits, for stamps beyond the clock, and where nothing is left.
Reference in_order(ReferenceRows rows, const ReferenceSpec& spec);

}  // namespace aslio::io
