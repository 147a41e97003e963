#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

#include "aslio/core/errors.hpp"
#include "point_file.hpp"

namespace aslio::io {
namespace {

constexpr std::size_t kMaxHeaderLines = 1000;

struct PlyType {
  std::string_view name, other_name;
  NumberKind kind;
  std::uint32_t size;
};
constexpr std::array<PlyType, 8> kTypes{{{"char", "int8", NumberKind::whole, 1},
                                         {"uchar", "uint8", NumberKind::natural, 1},
                                         {"short", "int16", NumberKind::whole, 2},
                                         {"ushort", "uint16", NumberKind::natural, 2},
                                         {"int", "int32", NumberKind::whole, 4},
                                         {"uint", "uint32", NumberKind::natural, 4},
                                         {"float", "float32", NumberKind::real, 4},
                                         {"double", "float64", NumberKind::real, 8}}};

struct PlyHeader {
  FileColumns columns;
  std::uint64_t points = 0;
  std::string format;
};

class PlyHeaderReader {
 public:
  PlyHeaderReader(TextLines& lines, const std::string& where) : lines_(lines), where_(where) {}

  PlyHeader read() {
    std::string_view line;
    if (!lines_.next(line) || line != "ply") refuse("it is no PLY file: its first line is not 'ply'");
    while (lines_.next(line)) {
      if (lines_.number() > kMaxHeaderLines) break;
      if (line == "end_header") return finish();
      take(std::string(line.substr(0, 200)));
    }
    refuse("the header has no line 'end_header'");
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw DataError(fmt::format("{}:{}: {}; write the file anew", where_, lines_.number(), why));
  }

  void take(const std::string& line) {
    std::istringstream words(line);
    std::string key, first, second;
    words >> key >> first >> second;
    if (key == "format") {
      header_.format = first;
    } else if (key == "element") {
      take_element(first, second);
    } else if (key == "property" && elements_ == 1) {
      take_property(first, second);
    }
  }

  void take_element(const std::string& name, const std::string& count) {
    if (++elements_ > 1) return;  // what lies behind the points
    if (name != "vertex") refuse(fmt::format("its first element is '{}', not 'vertex'", name.substr(0, 32)));
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), header_.points);
    if (count.empty() || error != std::errc{} || end != count.data() + count.size() ||
        header_.points > kMaxFilePoints) {
      refuse(fmt::format("'{}' is no number of points up to {}", count.substr(0, 32), kMaxFilePoints));
    }
  }

  void take_property(const std::string& type, const std::string& name) {
    const auto known = std::find_if(kTypes.begin(), kTypes.end(),
                                    [&](const PlyType& t) { return t.name == type || t.other_name == type; });
    if (known == kTypes.end()) refuse(fmt::format("a point has a property of type '{}'", type.substr(0, 32)));
    if (const std::string why = header_.columns.add({name, known->kind, known->size, 1, 0}); !why.empty()) refuse(why);
  }

  PlyHeader finish() {
    if (elements_ == 0 || header_.columns.all().empty()) refuse("it has no element 'vertex' with properties");
    return std::move(header_);
  }

  TextLines& lines_;
  const std::string& where_;
  PlyHeader header_;
  int elements_ = 0;
};

}  // namespace

void parse_ply(FileBytes file, const std::string& where, PointTable& table) {
  TextLines lines(file);
  const PlyHeader header = PlyHeaderReader(lines, where).read();
  header.columns.describe(table);
  if (header.format == "ascii") {
    read_ascii_points(lines, header.columns, header.points, where, table);
  } else if (header.format == "binary_little_endian") {
    take_binary_points(file.subspan(lines.offset()), header.columns, header.points, table);
  } else {
    throw DataError(
        fmt::format("{}: its format '{}' is neither ascii nor binary_little_endian; write it in one of these", where,
                    header.format.substr(0, 32)));
  }
}

}  // namespace aslio::io
