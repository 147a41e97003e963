#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace aslio::io::rosbag {

enum class ChunkCoding : std::uint8_t { none, lz4, bz2 };

/// Decompresses one chunk into `out`, never beyond `declared` bytes. Returns an empty text when the output has exactly
/// the declared size, otherwise what is wrong; `out` then holds what could be decompressed.
std::string decompress(ChunkCoding coding, std::span<const std::uint8_t> in, std::size_t declared,
                       std::vector<std::uint8_t>& out);

}  // namespace aslio::io::rosbag
