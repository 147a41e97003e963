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
#include <vector>

#include "aslio/core/errors.hpp"
#include "decompress.hpp"
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

std::string decompress_message(std::span<const std::uint8_t> in, std::uint64_t limit, ByteBuffer& out) {
  const auto declared = ZSTD_getFrameContentSize(in.data(), in.size());
  if (declared == ZSTD_CONTENTSIZE_ERROR) return "it is no Zstandard frame";
  if (declared == ZSTD_CONTENTSIZE_UNKNOWN) return "its Zstandard frame does not declare its size";
  if (declared > limit) return fmt::format("it declares {} bytes (at most {})", declared, limit);
  return decompress(ChunkCoding::zstd, in, static_cast<std::size_t>(declared), out);
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
