#pragma once
/// What a file is that is no recording of messages, so that its error can name the remedy.

#include <cstddef>
#include <string>
#include <string_view>

namespace aslio::io {

/// Bytes of the beginning of a file that foreign_format() looks at.
inline constexpr std::size_t kForeignHead = 24;

/// By the first bytes. Ends with what to do.
std::string foreign_format(std::string_view head);

}  // namespace aslio::io
