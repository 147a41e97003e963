#include "checksum.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio::io::mcap {

std::uint32_t crc32_of(Bytes bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

std::uint32_t crc32_of(const InputFile& file, std::uint64_t begin, std::uint64_t count, std::uint32_t before) {
  constexpr std::uint64_t kPiece = 256 * 1024;  // stays in the cache between reading and summing
  std::vector<std::uint8_t> piece(static_cast<std::size_t>(std::min(kPiece, count)));
  while (count > 0) {
    const std::span<std::uint8_t> part = std::span(piece).first(static_cast<std::size_t>(std::min(kPiece, count)));
    file.read(begin, part);
    before = crc32_of(part, before);
    begin += part.size();
    count -= part.size();
  }
  return before;
}

void DataChecksum::add(std::uint64_t begin, std::uint64_t count, std::uint32_t crc) {
  if (open()) parts_.insert_or_assign(begin, Part{count, crc});
}

void DataChecksum::check(const InputFile& file) {
  if (!open()) return;
  std::uint64_t position = 0;
  std::uint32_t found = 0;
  for (const auto& [begin, part] : parts_) {
    if (begin < position || begin > end_ || part.count > end_ - begin) continue;
    found = crc32_of(file, position, begin - position, found);
    found = static_cast<std::uint32_t>(crc32_combine(found, part.crc, static_cast<z_off_t>(part.count)));
    position = begin + part.count;
  }
  found = crc32_of(file, position, end_ - position, found);
  if (found != crc_) {
    throw DataError(fmt::format(
        "{}: damaged data section, from offset 0 to {}: its checksum is {:08x}, {:08x} is written behind it; "
        "copy the file again from its origin, or take out what is whole with `mcap recover`",
        file.path().string(), end_, found, crc_));
  }
  *this = DataChecksum{};
}

}  // namespace aslio::io::mcap
