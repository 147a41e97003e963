#pragma once

#include <map>

#include "../input_file.hpp"
#include "record.hpp"

namespace aslio::io::mcap {

/// CRC-32 of `bytes`, going on from `before`.
std::uint32_t crc32_of(Bytes bytes, std::uint32_t before = 0);

/// CRC-32 of `count` bytes of a file, read a piece at a time.
std::uint32_t crc32_of(const InputFile& file, std::uint64_t begin, std::uint64_t count, std::uint32_t before = 0);

/// The checksum of the data section. Pieces that have been read for other reasons are not read again for it.
class DataChecksum {
 public:
  DataChecksum() = default;
  /// Of the bytes in front of `end`; `crc` 0: there is none.
  DataChecksum(std::uint64_t end, std::uint32_t crc) : end_(end), crc_(crc) {}

  bool open() const { return crc_ != 0; }
  /// Tells the checksum of a part of the file. Pre: parts do not overlap, unless they are the same.
  void add(std::uint64_t begin, std::uint64_t count, std::uint32_t crc);
  std::size_t parts() const { return parts_.size(); }
  /// Checks it once: open() is false then. Throws DataError where it is wrong.
  void check(const InputFile& file);

 private:
  struct Part {
    std::uint64_t count;
    std::uint32_t crc;
  };
  std::uint64_t end_ = 0;
  std::uint32_t crc_ = 0;
  std::map<std::uint64_t, Part> parts_;  ///< by begin
};

}  // namespace aslio::io::mcap
