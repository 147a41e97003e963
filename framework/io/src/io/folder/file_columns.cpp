#include "file_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "aslio/core/errors.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kMaxColumns = 256;

/// As sensor_msgs/PointField numbers them.
std::uint8_t datatype(const FileColumn& column) {
  if (column.kind == NumberKind::real) return column.size == 4 ? 7 : 8;
  if (column.size == 8) return 8;
  const std::uint8_t natural = column.kind == NumberKind::natural ? 1 : 0;
  return static_cast<std::uint8_t>((column.size == 1 ? 1 : column.size == 2 ? 3 : 5) + natural);
}

template <class T>
bool write_number(std::string_view text, std::uint8_t* to) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error != std::errc{}) return false;
  std::memcpy(to, &value, sizeof(value));
  return true;
}

/// Reals too large for float32 are no return; whole numbers may be written like reals.
bool write_real(std::string_view text, const FileColumn& column, std::uint8_t* to) {
  if (column.size == 8) return write_number<double>(text, to);
  std::array<std::uint8_t, 8> bytes{};
  if (!write_number<double>(text, bytes.data())) return false;
  double value = 0;
  std::memcpy(&value, bytes.data(), sizeof(value));
  constexpr double kMost = std::numeric_limits<float>::max();
  const float narrow = std::abs(value) > kMost ? std::numeric_limits<float>::infinity() : static_cast<float>(value);
  std::memcpy(to, &narrow, sizeof(narrow));
  return true;
}

bool write(std::string_view text, const FileColumn& column, std::uint8_t* to) {
  if (column.kind == NumberKind::real) return write_real(text, column, to);
  const bool natural = column.kind == NumberKind::natural;
  switch (column.size) {
    case 1:
      return natural ? write_number<std::uint8_t>(text, to) : write_number<std::int8_t>(text, to);
    case 2:
      return natural ? write_number<std::uint16_t>(text, to) : write_number<std::int16_t>(text, to);
    case 4:
      return natural ? write_number<std::uint32_t>(text, to) : write_number<std::int32_t>(text, to);
    default:
      return natural ? write_number<std::uint64_t>(text, to) : write_number<std::int64_t>(text, to);
  }
}

/// CloudCompare writes `scalar_Time`; names of messages are in lower case.
std::string plain_name(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr std::string_view kScalar = "scalar_";
  if (name.starts_with(kScalar)) name.erase(0, kScalar.size());
  return name;
}

template <class T>
void to_double(std::uint8_t* number) {
  T value;
  std::memcpy(&value, number, sizeof(value));
  const auto real = static_cast<double>(value);
  std::memcpy(number, &real, sizeof(real));
}

std::optional<FileColumn> declared(std::string_view word) {
  const std::size_t colon = word.find(':');
  FileColumn column;
  column.name = word.substr(0, colon);
  if (colon == std::string_view::npos) return column;
  const std::string_view type = word.substr(colon + 1);
  constexpr std::string_view kKinds = "iuf";
  const std::size_t kind = type.empty() ? std::string_view::npos : kKinds.find(type[0]);
  constexpr std::array<std::string_view, 4> kBits{"8", "16", "32", "64"};
  const auto bits = std::find(kBits.begin(), kBits.end(), type.empty() ? type : type.substr(1));
  if (kind == std::string_view::npos || bits == kBits.end()) return std::nullopt;
  column.kind = static_cast<NumberKind>(kind);
  column.size = 1U << (bits - kBits.begin());
  return column;
}

}  // namespace

std::string FileColumns::add(FileColumn column) {
  const bool real = column.kind == NumberKind::real;
  const bool size_known = column.size == 4 || column.size == 8 || (!real && (column.size == 1 || column.size == 2));
  const std::string name = column.name.substr(0, 32);
  if (!size_known) return fmt::format("column '{}' has numbers of {} bytes", name, column.size);
  constexpr std::uint32_t kMost = 1U << 16U;  // of a point
  if (columns_.size() >= kMaxColumns || column.count == 0 || column.count > kMost ||
      step_ + std::uint64_t{column.size} * column.count > kMost) {
    return fmt::format("column '{}' makes a point larger than {} columns or {} bytes", name, kMaxColumns, kMost);
  }
  column.offset = step_;
  step_ += column.size * column.count;
  numbers_ += column.count;
  columns_.push_back(std::move(column));
  return {};
}

void FileColumns::describe(PointTable& table) const {
  table.columns.clear();
  table.point_step = step_;
  for (const FileColumn& c : columns_) table.columns.push_back({plain_name(c.name), c.offset, datatype(c), c.count});
}

void FileColumns::convert(PointTable& table) const {
  for (const FileColumn& c : columns_) {
    if (c.size != 8 || c.kind == NumberKind::real) continue;
    for (std::size_t at = c.offset; at < table.bytes.size(); at += step_) {
      for (std::uint32_t i = 0; i < c.count; ++i) {
        std::uint8_t* number = table.bytes.data() + at + std::size_t{8} * i;
        c.kind == NumberKind::whole ? to_double<std::int64_t>(number) : to_double<std::uint64_t>(number);
      }
    }
  }
}

std::string FileColumns::write_line(std::string_view line, std::uint8_t* point) const {
  constexpr std::string_view kBlank = " \t\r";
  for (const FileColumn& c : columns_) {
    for (std::uint32_t i = 0; i < c.count; ++i) {
      line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlank)));
      const std::string_view text = line.substr(0, line.find_first_of(kBlank));
      line.remove_prefix(text.size());
      if (text.empty()) return fmt::format("it has no number for column '{}'", c.name.substr(0, 32));
      if (!write(text, c, point + c.offset + std::size_t{c.size} * i)) {
        return fmt::format("'{}' is no number of column '{}'", text.substr(0, 32), c.name.substr(0, 32));
      }
    }
  }
  return {};
}

FileColumns declared_columns(std::string_view text, const std::string& where) {
  constexpr std::string_view kBlank = " \t,";
  FileColumns columns;
  const std::string all(text);
  while (true) {
    text.remove_prefix(std::min(text.size(), text.find_first_not_of(kBlank)));
    if (text.empty()) break;
    const std::string_view word = text.substr(0, text.find_first_of(kBlank));
    text.remove_prefix(word.size());
    auto column = declared(word);
    const std::string why =
        column ? columns.add(std::move(*column)) : "its type is none of f32, f64, i8 to i64, u8 to u64";
    if (!why.empty()) throw DataError(fmt::format("{}: '{}' in `scan_columns: {}`: {}", where, word, all, why));
  }
  if (columns.all().empty()) throw DataError(fmt::format("{}: `scan_columns: {}` names no column", where, all));
  return columns;
}

}  // namespace aslio::io
