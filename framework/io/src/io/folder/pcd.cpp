#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

#include "aslio/core/errors.hpp"
#include "point_file.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kMaxHeaderLines = 200;

struct PcdHeader {
  FileColumns columns;
  std::uint64_t width = 0, height = 1;
  std::optional<std::uint64_t> points;
  std::string data;
};

std::vector<std::string_view> words(std::string_view line) {
  constexpr std::string_view kBlank = " \t";
  std::vector<std::string_view> found;
  while (true) {
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlank)));
    if (line.empty()) return found;
    found.push_back(line.substr(0, line.find_first_of(kBlank)));
    line.remove_prefix(found.back().size());
  }
}

std::optional<std::uint64_t> natural(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

class PcdHeaderReader {
 public:
  PcdHeaderReader(TextLines& lines, const std::string& where) : lines_(lines), where_(where) {}

  PcdHeader read() {
    std::string_view line;
    while (lines_.next(line)) {
      if (lines_.number() > kMaxHeaderLines) refuse("the header has no DATA line");
      const auto all = words(line);
      if (all.empty() || all[0].starts_with('#')) continue;
      const std::vector<std::string_view> rest(all.begin() + 1, all.end());
      take(all[0], rest);
      if (all[0] == "DATA") return finish();
    }
    refuse("the file ends inside its header: it is no PCD file, or cut short");
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw DataError(fmt::format("{}:{}: {}; write the file anew", where_, lines_.number(), why));
  }

  std::uint64_t number(const std::vector<std::string_view>& rest, std::size_t i, std::string_view key) const {
    const auto value = i < rest.size() ? natural(rest[i]) : std::nullopt;
    if (!value) refuse(fmt::format("{} lacks a number", key));
    return *value;
  }

  void take(std::string_view key, const std::vector<std::string_view>& rest) {
    if (key == "FIELDS" || key == "COLUMNS") {
      names_.assign(rest.begin(), rest.end());
    } else if (key == "SIZE") {
      sizes_.assign(rest.begin(), rest.end());
    } else if (key == "TYPE") {
      types_.assign(rest.begin(), rest.end());
    } else if (key == "COUNT") {
      counts_.assign(rest.begin(), rest.end());
    } else if (key == "WIDTH") {
      header_.width = number(rest, 0, key);
    } else if (key == "HEIGHT") {
      header_.height = number(rest, 0, key);
    } else if (key == "POINTS") {
      header_.points = number(rest, 0, key);
    } else if (key == "DATA") {
      header_.data = rest.empty() ? std::string{} : std::string(rest[0]);
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      refuse(fmt::format("'{}' is no line of a PCD header", key.substr(0, 32)));
    }
  }

  PcdHeader finish() {
    if (names_.empty() || sizes_.size() != names_.size() || types_.size() != names_.size() ||
        (!counts_.empty() && counts_.size() != names_.size())) {
      refuse(fmt::format("FIELDS names {} columns, SIZE {}, TYPE {}, COUNT {}", names_.size(), sizes_.size(),
                         types_.size(), counts_.size()));
    }
    for (std::size_t i = 0; i < names_.size(); ++i) add_column(i);
    constexpr std::uint64_t kSide = std::uint64_t{1} << 32U;  // so that a product fits
    const bool large = header_.width >= kSide || header_.height >= kSide;
    if (large || header_.width * header_.height > kMaxFilePoints) {
      refuse(fmt::format("it claims {} x {} points (at most {})", header_.width, header_.height, kMaxFilePoints));
    }
    if (header_.points.value_or(header_.width * header_.height) != header_.width * header_.height) {
      refuse(fmt::format("POINTS is {}, WIDTH x HEIGHT {} x {}", *header_.points, header_.width, header_.height));
    }
    return std::move(header_);
  }

  void add_column(std::size_t i) {
    FileColumn column;
    column.name = names_[i];
    constexpr std::string_view kTypes = "IUF";
    const std::size_t kind = types_[i].size() == 1 ? kTypes.find(types_[i]) : std::string_view::npos;
    if (kind == std::string_view::npos) refuse(fmt::format("TYPE '{}' is none of I, U, F", types_[i].substr(0, 32)));
    column.kind = static_cast<NumberKind>(kind);
    const std::uint64_t size = natural(sizes_[i]).value_or(0);
    const std::uint64_t count = counts_.empty() ? 1 : natural(counts_[i]).value_or(0);
    column.size = static_cast<std::uint32_t>(std::min<std::uint64_t>(size, 16));
    column.count = static_cast<std::uint32_t>(std::min<std::uint64_t>(count, 1U << 20U));
    if (const std::string why = header_.columns.add(std::move(column)); !why.empty()) refuse(why);
  }

  TextLines& lines_;
  const std::string& where_;
  std::vector<std::string> names_, sizes_, types_, counts_;
  PcdHeader header_;
};

/// All numbers of the first column come first, then those of the second.
void interleave(FileBytes columnwise, const FileColumns& columns, std::uint64_t points, PointTable& table) {
  const std::size_t step = columns.point_step();
  table.bytes.resize(columnwise.size());
  std::size_t from = 0;
  for (const FileColumn& c : columns.all()) {
    const std::size_t length = std::size_t{c.size} * c.count;
    for (std::size_t i = 0; i < points; ++i, from += length) {
      std::memcpy(table.bytes.data() + i * step + c.offset, columnwise.data() + from, length);
    }
  }
}

void take_compressed(FileBytes data, std::size_t offset, const FileColumns& columns, std::uint64_t points,
                     const std::string& where, PointTable& table) {
  constexpr std::size_t kHead = 8;
  const auto refuse = [&](const std::string& why) {
    throw DataError(fmt::format("{}: at offset {}: {}; write the file anew", where, offset, why));
  };
  if (points == 0) return;
  if (data.size() < kHead) refuse("the file ends before its compressed points");
  std::uint32_t compressed = 0, plain = 0;
  std::memcpy(&compressed, data.data(), 4);
  std::memcpy(&plain, data.data() + 4, 4);
  const std::uint64_t needed = points * columns.point_step();
  if (plain != needed) refuse(fmt::format("its points take {} bytes, {} are claimed", needed, plain));
  if (compressed > data.size() - kHead) {
    refuse(fmt::format("{} bytes of compressed points are claimed, {} are there", compressed, data.size() - kHead));
  }
  // Three bytes of LZF make 264 at most: the claim cannot be larger, nor the memory taken for it.
  if (plain / 88 > std::uint64_t{compressed} + 1 || plain > kMaxScanBytes) {
    refuse(fmt::format("{} bytes cannot be made of {} compressed ones", plain, compressed));
  }
  std::vector<std::uint8_t> columnwise(plain);
  if (!decompress_lzf(data.subspan(kHead, compressed), columnwise)) refuse("its compressed points are damaged");
  interleave(columnwise, columns, points, table);
  columns.convert(table);
}

}  // namespace

void parse_pcd(FileBytes file, const std::string& where, PointTable& table) {
  TextLines lines(file);
  const PcdHeader header = PcdHeaderReader(lines, where).read();
  const std::uint64_t points = header.width * header.height;
  header.columns.describe(table);
  const std::size_t offset = lines.offset();
  if (header.data == "ascii") {
    read_ascii_points(lines, header.columns, points, where, table);
  } else if (header.data == "binary") {
    take_binary_points(file.subspan(offset), header.columns, points, table);
  } else if (header.data == "binary_compressed") {
    take_compressed(file.subspan(offset), offset, header.columns, points, where, table);
  } else {
    throw DataError(fmt::format("{}:{}: DATA '{}' is none of ascii, binary, binary_compressed", where, lines.number(),
                                header.data.substr(0, 32)));
  }
}

}  // namespace aslio::io
