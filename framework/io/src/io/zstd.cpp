#include "zstd.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "aslio/core/errors.hpp"
#include "input_file.hpp"

namespace aslio::io {
namespace {

using Stream = std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)>;

Stream make_stream() {
  Stream stream(ZSTD_createDStream(), &ZSTD_freeDStream);
  if (!stream) throw std::bad_alloc();
  return stream;
}

}  // namespace

bool is_zstd(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kMagic[] = {0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= sizeof(kMagic) && std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) == 0;
}

std::string decompress_zstd(std::span<const std::uint8_t> in, std::uint64_t limit, std::vector<std::uint8_t>& out) {
  constexpr std::uint64_t kStep = 1U << 20U;
  const auto declared = ZSTD_getFrameContentSize(in.data(), in.size());
  if (declared == ZSTD_CONTENTSIZE_ERROR) return "it is no Zstandard frame";
  const bool known = declared != ZSTD_CONTENTSIZE_UNKNOWN;
  if (known && declared > limit) return fmt::format("it declares {} bytes (at most {})", declared, limit);
  const Stream stream = make_stream();
  ZSTD_inBuffer from{in.data(), in.size(), 0};
  out.resize(static_cast<std::size_t>(known ? declared : std::min(limit, kStep)));
  ZSTD_outBuffer to{out.data(), out.size(), 0};
  while (true) {
    const std::size_t taken = from.pos, given = to.pos;
    const std::size_t left = ZSTD_decompressStream(stream.get(), &to, &from);
    if (ZSTD_isError(left) != 0) return fmt::format("zstd: {}", ZSTD_getErrorName(left));
    if (left == 0) break;
    if (to.pos == to.size) {
      if (known || to.size >= limit) return fmt::format("it decompresses to more than {} bytes", to.size);
      out.resize(static_cast<std::size_t>(std::min<std::uint64_t>(limit, to.size * std::uint64_t{2})));
      to = {out.data(), out.size(), to.pos};
    } else if (from.pos == taken && to.pos == given) {
      return fmt::format("its Zstandard frame ends after {} bytes", to.pos);
    }
  }
  out.resize(to.pos);
  return {};
}

ScratchFile::ScratchFile(const std::filesystem::path& from, const std::filesystem::path& folder) {
  create(folder.empty() ? std::filesystem::temp_directory_path() : folder);
  try {
    fill(from);
  } catch (...) {
    hide();
    ::close(fd_);
    throw;
  }
}

ScratchFile::~ScratchFile() {
  hide();
  ::close(fd_);
}

void ScratchFile::create(const std::filesystem::path& folder) {
  std::string name = (folder / "aslio_XXXXXX").string();
  fd_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (fd_ < 0) {
    throw DataError(fmt::format("{}: no temporary file can be made: {}; set TMPDIR to a folder that can be written",
                                folder.string(), std::strerror(errno)));
  }
  path_ = name;
}

void ScratchFile::hide() {
  if (path_.empty()) return;
  ::unlink(path_.c_str());
  path_.clear();
}

void ScratchFile::write(std::span<const std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t done = ::write(fd_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      throw DataError(
          fmt::format("{}: cannot write the decompressed recording: {}; set TMPDIR to a folder with room, or "
                      "decompress the file with `unzstd`",
                      path_.string(), std::strerror(errno)));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
}

void ScratchFile::fill(const std::filesystem::path& from) {
  const InputFile file(from);
  const Stream stream = make_stream();
  std::vector<std::uint8_t> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  std::size_t left = 0;
  for (std::uint64_t at = 0; at < file.size();) {
    const auto part =
        std::span(in).first(static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), file.size() - at)));
    file.read(at, part);
    at += part.size();
    ZSTD_inBuffer packed{part.data(), part.size(), 0};
    // A full output buffer may hide more that is ready.
    for (bool full = false; packed.pos < packed.size || full;) {
      ZSTD_outBuffer plain{out.data(), out.size(), 0};
      left = ZSTD_decompressStream(stream.get(), &plain, &packed);
      if (ZSTD_isError(left) != 0) {
        throw DataError(fmt::format("{}: damaged before offset {}: zstd: {}; copy it again from its origin",
                                    from.string(), at, ZSTD_getErrorName(left)));
      }
      write(std::span(out).first(plain.pos));
      full = plain.pos == plain.size;
    }
  }
  cut_ = left != 0;
}

}  // namespace aslio::io
