#include "compress.hpp"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include "aslio/core/errors.hpp"

namespace aslio::io {

std::vector<std::uint8_t> compress_lz4(std::span<const std::uint8_t> raw) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.blockSizeID = LZ4F_max4MB;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::vector<std::uint8_t> out(LZ4F_compressFrameBound(raw.size(), &preferences));
  const std::size_t size = LZ4F_compressFrame(out.data(), out.size(), raw.data(), raw.size(), &preferences);
  if (LZ4F_isError(size) != 0) throw DataError(fmt::format("lz4: {}", LZ4F_getErrorName(size)));
  out.resize(size);
  return out;
}

std::vector<std::uint8_t> compress_zstd(std::span<const std::uint8_t> raw) {
  constexpr int kFastest = 1;
  std::vector<std::uint8_t> out(ZSTD_compressBound(raw.size()));
  const std::size_t size = ZSTD_compress(out.data(), out.size(), raw.data(), raw.size(), kFastest);
  if (ZSTD_isError(size) != 0) throw DataError(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
  out.resize(size);
  return out;
}

}  // namespace aslio::io
