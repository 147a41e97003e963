#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "byte_buffer.hpp"

namespace aslio::io {

enum class ChunkCoding : std::uint8_t { none, lz4, bz2, zstd };

/// Decompresses one chunk into `out`, never beyond `declared` bytes. Returns an empty text when the output has exactly
/// the declared size, otherwise what is wrong; `out` then holds what could be decompressed. Pre: a coding but none.
std::string decompress(ChunkCoding coding, std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out);

}  // namespace aslio::io
