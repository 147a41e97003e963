#pragma once
/// Zstandard, bounded: nothing is allocated or written beyond a limit, whatever a frame declares.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "byte_buffer.hpp"

namespace aslio::io {

/// Begins with the magic number of a Zstandard frame.
bool is_zstd(std::span<const std::uint8_t> bytes);

/// Decompresses one message, whose frame declares its size, into `out`. Empty text, or what is wrong with it.
std::string decompress_message(std::span<const std::uint8_t> in, std::uint64_t limit, ByteBuffer& out);

/// A file that goes with the object, in whatever way the program ends once it is hidden.
class ScratchFile {
 public:
  /// Decompresses `from` into a new file of `folder` (empty: that of temporary files). Throws DataError for damage, and
  /// where the disk is full. A frame that is cut short gives what is there; `cut` says so.
  ScratchFile(const std::filesystem::path& from, const std::filesystem::path& folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool cut() const { return cut_; }
  /// Takes its name away: who has it open reads on.
  void hide();

 private:
  void create(const std::filesystem::path& folder);
  void fill(const std::filesystem::path& from);
  void write(std::span<const std::uint8_t> bytes) const;

  std::filesystem::path path_;
  int fd_ = -1;
  bool cut_ = false;
};

}  // namespace aslio::io
