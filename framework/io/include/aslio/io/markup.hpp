#pragma once
/// Bytes and texts as they go into pages and pictures.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace aslio::io {

/// Base64 of bytes (RFC 4648, padded).
std::string base64(std::span<const std::uint8_t> bytes);

/// Text for an element or a quoted attribute of HTML or SVG.
std::string html_escaped(std::string_view text);

}  // namespace aslio::io
