#include "decompress.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace aslio::io::rosbag {
namespace {

/// Takes one byte more than declared, so that a longer stream shows itself.
std::string judge(std::size_t produced, std::size_t declared, bool ended, std::vector<std::uint8_t>& out) {
  out.resize(std::min(produced, declared));
  if (produced > declared) return fmt::format("decompresses to more than the {} bytes declared", declared);
  if (!ended) return fmt::format("compressed data ends after {} of {} bytes", produced, declared);
  if (produced < declared) return fmt::format("decompresses to {} bytes, {} declared", produced, declared);
  return {};
}

std::string decompress_lz4(std::span<const std::uint8_t> in, std::size_t declared, std::vector<std::uint8_t>& out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) return "lz4 cannot start";
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  std::size_t produced = 0, consumed = 0;
  while (true) {
    std::size_t room = out.size() - produced, take = in.size() - consumed;
    const std::size_t hint =
        LZ4F_decompress(context.get(), out.data() + produced, &room, in.data() + consumed, &take, nullptr);
    produced += room;
    consumed += take;
    if (LZ4F_isError(hint)) {
      out.resize(std::min(produced, declared));
      return fmt::format("lz4: {}", LZ4F_getErrorName(hint));
    }
    if (hint == 0) return judge(produced, declared, true, out);
    if (room == 0 && take == 0) return judge(produced, declared, false, out);
  }
}

std::string decompress_bz2(std::span<const std::uint8_t> in, std::size_t declared, std::vector<std::uint8_t>& out) {
  if (in.size() > std::numeric_limits<unsigned>::max()) return "bz2: chunk too long";
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return "bz2 cannot start";
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> guard(&stream, &BZ2_bzDecompressEnd);
  // The library takes a non-const pointer but does not write to its input.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));
  stream.avail_in = static_cast<unsigned>(in.size());
  stream.next_out = reinterpret_cast<char*>(out.data());
  stream.avail_out = static_cast<unsigned>(out.size());
  int result = BZ_OK;
  unsigned last_in = 0, last_out = 0;
  do {
    last_in = stream.avail_in;
    last_out = stream.avail_out;
    result = BZ2_bzDecompress(&stream);
  } while (result == BZ_OK && (stream.avail_in != last_in || stream.avail_out != last_out));
  const std::size_t produced = out.size() - stream.avail_out;
  if (result != BZ_OK && result != BZ_STREAM_END) {
    out.resize(std::min(produced, declared));
    return fmt::format("bz2: damaged data (code {})", result);
  }
  return judge(produced, declared, result == BZ_STREAM_END, out);
}

}  // namespace

std::string decompress(ChunkCoding coding, std::span<const std::uint8_t> in, std::size_t declared,
                       std::vector<std::uint8_t>& out) {
  out.resize(declared + 1);
  return coding == ChunkCoding::lz4 ? decompress_lz4(in, declared, out) : decompress_bz2(in, declared, out);
}

}  // namespace aslio::io::rosbag
