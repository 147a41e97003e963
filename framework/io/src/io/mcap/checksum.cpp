#include "checksum.hpp"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio::io::mcap {
namespace {

/// Product of two polynomials over GF(2) modulo that of the CRC; the highest bit is the coefficient of x^0.
std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t kPolynomial = 0xEDB88320;
  std::uint32_t product = 0;
  for (std::uint32_t bit = 1U << 31U; bit != 0; bit >>= 1U) {
    if ((a & bit) != 0) product ^= b;
    b = (b & 1U) != 0 ? (b >> 1U) ^ kPolynomial : b >> 1U;
  }
  return product;
}

/// The CRC of a text of CRC `first` with `count` bytes of CRC `second` behind it: first * x^(8 count) + second.
std::uint32_t joined(std::uint32_t first, std::uint32_t second, std::uint64_t count) {
  std::uint32_t power = 1U << 23U;  // x^8, squared again and again
  for (; count != 0; count >>= 1U) {
    if ((count & 1U) != 0) first = multiply(first, power);
    power = multiply(power, power);
  }
  return first ^ second;
}

}  // namespace

std::uint32_t crc32_of(Bytes bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
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
    found = joined(found, part.crc, part.count);
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
