#include "decompress.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace aslio::io {
namespace {

std::string judge(std::size_t produced, std::size_t declared, bool ended, ByteBuffer& out) {
  out.shrink(std::min(produced, declared));
  if (produced > declared) return fmt::format("decompresses to more than the {} bytes declared", declared);
  if (!ended) return fmt::format("compressed data ends after {} of {} bytes", produced, declared);
  if (produced < declared) return fmt::format("decompresses to {} bytes, {} declared", produced, declared);
  return {};
}

std::string decompress_lz4(std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) return "lz4 cannot start";
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  LZ4F_decompressOptions_t options{};
  options.stableDst = 1;  // the output stays where it is: the library keeps no copy of its last 64 kB
  std::size_t produced = 0, consumed = 0;
  while (true) {
    std::size_t room = out.size() - produced, take = in.size() - consumed;
    const std::size_t hint =
        LZ4F_decompress(context.get(), out.data() + produced, &room, in.data() + consumed, &take, &options);
    produced += room;
    consumed += take;
    if (LZ4F_isError(hint)) {
      out.shrink(std::min(produced, declared));
      return fmt::format("lz4: {}", LZ4F_getErrorName(hint));
    }
    if (hint == 0) return judge(produced, declared, true, out);
    if (room == 0 && take == 0) return judge(produced, declared, false, out);
  }
}

std::string decompress_bz2(std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out) {
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
    out.shrink(std::min(produced, declared));
    return fmt::format("bz2: damaged data (code {})", result);
  }
  return judge(produced, declared, result == BZ_STREAM_END, out);
}

/// What is there of a frame that was cut.
void decompress_cut_zstd(std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  ZSTD_inBuffer from{in.data(), in.size(), 0};
  ZSTD_outBuffer to{out.data(), declared, 0};
  std::size_t last_in = 0, last_out = 0, result = 0;
  do {
    last_in = from.pos;
    last_out = to.pos;
    result = ZSTD_decompressStream(context.get(), &to, &from);
  } while (!ZSTD_isError(result) && (from.pos != last_in || to.pos != last_out));
  out.shrink(to.pos);
}

std::string decompress_zstd(std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) return "zstd cannot start";
  // In one go the output is its own window: nothing is copied, and a frame cannot ask for more memory than is declared.
  const std::size_t produced = ZSTD_decompressDCtx(context.get(), out.data(), out.size(), in.data(), in.size());
  if (!ZSTD_isError(produced)) return judge(produced, declared, true, out);
  const ZSTD_ErrorCode code = ZSTD_getErrorCode(produced);
  if (code == ZSTD_error_dstSize_tooSmall) return judge(declared + 1, declared, true, out);
  decompress_cut_zstd(in, declared, out);
  if (code == ZSTD_error_srcSize_wrong) return judge(out.size(), declared, false, out);
  return fmt::format("zstd: {}", ZSTD_getErrorName(produced));
}

}  // namespace

std::string decompress(ChunkCoding coding, std::span<const std::uint8_t> in, std::size_t declared, ByteBuffer& out) {
  // One byte more than declared, so that a longer stream shows itself.
  out.reset(declared + 1);
  switch (coding) {
    case ChunkCoding::lz4:
      return decompress_lz4(in, declared, out);
    case ChunkCoding::bz2:
      return decompress_bz2(in, declared, out);
    case ChunkCoding::zstd:
      return decompress_zstd(in, declared, out);
    case ChunkCoding::none:
      break;
  }
  out.shrink(0);
  return "not compressed";
}

}  // namespace aslio::io
