#include "point_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "../input_file.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::io {

bool TextLines::next(std::string_view& line) {
  if (left_.empty()) return false;
  const std::size_t end = left_.find('\n');
  line = left_.substr(0, end);
  left_.remove_prefix(end == std::string_view::npos ? left_.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++number_;
  return true;
}

bool decompress_lzf(FileBytes from, std::span<std::uint8_t> to) {
  std::size_t in = 0, out = 0;
  while (in < from.size()) {
    const unsigned control = from[in++];
    if (control < 32) {  // bytes as they are
      const std::size_t count = control + 1;
      if (count > from.size() - in || count > to.size() - out) return false;
      std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(in), count, to.begin() + static_cast<std::ptrdiff_t>(out));
      in += count;
      out += count;
      continue;
    }
    std::size_t count = (control >> 5U) + 2;  // of bytes that were there before
    if (control >> 5U == 7) {
      if (in == from.size()) return false;
      count += from[in++];
    }
    if (in == from.size()) return false;
    const std::size_t back = ((control & 31U) << 8U) + from[in++] + 1;
    if (back > out || count > to.size() - out) return false;
    for (; count > 0; --count, ++out) to[out] = to[out - back];  // it may reach into what it writes
  }
  return out == to.size();
}

void read_ascii_points(TextLines& lines, const FileColumns& columns, std::uint64_t points, const std::string& where,
                       PointTable& table) {
  const std::size_t step = columns.point_step();
  std::string_view line;
  std::uint64_t count = 0;
  while (count < points && lines.next(line)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    if (table.bytes.size() + step > kMaxScanBytes) {
      throw DataError(fmt::format("{}:{}: more than {} bytes of points", where, lines.number(), kMaxScanBytes));
    }
    table.bytes.resize(table.bytes.size() + step);
    if (const std::string why = columns.write_line(line, table.bytes.data() + table.bytes.size() - step);
        !why.empty()) {
      throw DataError(fmt::format("{}:{}: {}; write the file anew", where, lines.number(), why));
    }
    ++count;
  }
  if (count < points) table.damage = fmt::format("it holds {} of {} points", count, points);
  columns.convert(table);
}

void take_binary_points(FileBytes data, const FileColumns& columns, std::uint64_t points, PointTable& table) {
  const std::uint64_t whole = std::min<std::uint64_t>(points, data.size() / columns.point_step());
  const FileBytes part = data.first(static_cast<std::size_t>(whole * columns.point_step()));
  table.bytes.assign(part.begin(), part.end());
  if (whole < points) table.damage = fmt::format("it holds {} of {} points", whole, points);
  columns.convert(table);
}

void parse_bin(FileBytes file, const FileColumns& columns, PointTable& table) {
  columns.describe(table);
  take_binary_points(file, columns, file.size() / columns.point_step(), table);
  if (file.size() % columns.point_step() != 0) table.damage = "the file ends inside a point";
}

void read_point_file(const std::filesystem::path& path, const FileColumns& bin, PointTable& table) {
  const InputFile file(path);
  if (file.size() > kMaxScanBytes) {
    throw DataError(fmt::format("{}: {} bytes are no scan (at most {})", path.string(), file.size(), kMaxScanBytes));
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(file.size()));
  file.read(0, bytes);
  const std::string extension = path.extension().string();
  if (extension == ".pcd") return parse_pcd(bytes, path.string(), table);
  if (extension == ".ply") return parse_ply(bytes, path.string(), table);
  parse_bin(bytes, bin, table);
}

}  // namespace aslio::io
