#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace aslio::io {

/// One LZ4 frame as roslz4 insists on it: independent blocks of up to 4 MB, without their checksums, without the size
/// of the content. Throws DataError.
std::vector<std::uint8_t> compress_lz4(std::span<const std::uint8_t> raw);
/// One Zstandard frame that declares its size. Throws DataError.
std::vector<std::uint8_t> compress_zstd(std::span<const std::uint8_t> raw);

}  // namespace aslio::io
