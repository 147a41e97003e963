#pragma once
/// Checked random access to a file (through a sliding window) or to memory.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aslio::io {

class InputFile {
 public:
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::uint64_t size() const { return size_; }
  const std::filesystem::path& path() const { return path_; }
  /// Fills `to` from `offset`. Throws DataError when the file cannot be read or has become shorter.
  void read(std::uint64_t offset, std::span<std::uint8_t> to) const;

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

/// All of a file that belongs to a recording. Throws DataError when it cannot be read, or is larger than `most` bytes
/// and so not `what` it should be.
std::string read_small_file(const std::filesystem::path& path, std::uint64_t most, std::string_view what);

class ByteView {
 public:
  explicit ByteView(const InputFile& file) : file_(&file), size_(file.size()) {}
  explicit ByteView(std::span<const std::uint8_t> memory) : memory_(memory.data()), size_(memory.size()) {}

  std::uint64_t size() const { return size_; }
  /// Pointer to `count` bytes at `offset`, valid until the next call. Pre: offset + count <= size().
  const std::uint8_t* at(std::uint64_t offset, std::size_t count);

 private:
  const InputFile* file_ = nullptr;
  const std::uint8_t* memory_ = nullptr;
  std::uint64_t size_ = 0;
  std::uint64_t window_begin_ = 0, window_end_ = 0;
  std::vector<std::uint8_t> window_;
};

}  // namespace aslio::io
