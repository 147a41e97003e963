// Files of points: what their headers may claim, and what their bytes may hold.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "../../framework/io/src/io/folder/decimal.hpp"
#include "../../framework/io/src/io/folder/point_file.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
void append(Bytes& bytes, T value) {
  const auto* from = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof(value));
}

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

template <class T>
T number(const PointTable& table, std::size_t point, const std::string& column) {
  for (const auto& c : table.columns) {
    if (c.name != column) continue;
    T value;
    std::memcpy(&value, table.bytes.data() + point * table.point_step + c.offset, sizeof(value));
    return value;
  }
  FAIL("no column " << column);
  return {};
}

const std::string kFields =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity t ring\nSIZE 4 4 4 4 4 1\nTYPE F F F F U U\nCOUNT 1 1 1 1 1 1\n";

std::string pcd_header(const std::string& data, std::size_t points) {
  return kFields + fmt::format("WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA {1}\n", points, data);
}

/// Point `i` at (i, 2 i, 0.5).
Bytes pcd_point(std::uint32_t i) {
  Bytes point;
  for (const float v : {static_cast<float>(i), static_cast<float>(2 * i), 0.5F, 7.0F}) append(point, v);
  append(point, 1000 * i);
  append(point, static_cast<std::uint8_t>(i % 16));
  return point;
}

PointTable pcd(const Bytes& file) {
  PointTable table;
  parse_pcd(file, "f.pcd", table);
  return table;
}

PointTable ply(const Bytes& file) {
  PointTable table;
  parse_ply(file, "f.ply", table);
  return table;
}

void check_points(const PointTable& table, std::uint32_t points) {
  REQUIRE(table.bytes.size() == points * table.point_step);
  for (std::uint32_t i = 0; i < points; ++i) {
    CHECK(number<float>(table, i, "x") == static_cast<float>(i));
    CHECK(number<float>(table, i, "y") == static_cast<float>(2 * i));
    CHECK(number<std::uint32_t>(table, i, "t") == 1000 * i);
    CHECK(number<std::uint8_t>(table, i, "ring") == i % 16);
  }
}

/// Runs of bytes as they are: the simplest LZF.
Bytes stored(const Bytes& plain) {
  Bytes out;
  for (std::size_t at = 0; at < plain.size(); at += 32) {
    const std::size_t count = std::min<std::size_t>(32, plain.size() - at);
    out.push_back(static_cast<std::uint8_t>(count - 1));
    out.insert(out.end(), plain.begin() + static_cast<std::ptrdiff_t>(at),
               plain.begin() + static_cast<std::ptrdiff_t>(at + count));
  }
  return out;
}

Bytes compressed_pcd(std::uint32_t points) {
  Bytes columns;
  std::size_t from = 0;
  for (const std::size_t size : {4U, 4U, 4U, 4U, 4U, 1U}) {
    for (std::uint32_t i = 0; i < points; ++i) {
      const Bytes point = pcd_point(i);
      columns.insert(columns.end(), point.begin() + static_cast<std::ptrdiff_t>(from),
                     point.begin() + static_cast<std::ptrdiff_t>(from + size));
    }
    from += size;
  }
  const Bytes packed = stored(columns);
  Bytes file = bytes_of(pcd_header("binary_compressed", points));
  append(file, static_cast<std::uint32_t>(packed.size()));
  append(file, static_cast<std::uint32_t>(columns.size()));
  file.insert(file.end(), packed.begin(), packed.end());
  return file;
}

}  // namespace

TEST_CASE("the three encodings of a PCD file yield the same points") {
  std::string ascii = pcd_header("ascii", 20);
  Bytes binary = bytes_of(pcd_header("binary", 20));
  for (std::uint32_t i = 0; i < 20; ++i) {
    ascii += fmt::format("{} {} 0.5 7 {} {}\r\n", i, 2 * i, 1000 * i, i % 16);
    const Bytes point = pcd_point(i);
    binary.insert(binary.end(), point.begin(), point.end());
  }
  check_points(pcd(bytes_of(ascii)), 20);
  check_points(pcd(binary), 20);
  check_points(pcd(compressed_pcd(20)), 20);
  const PointTable table = pcd(binary);
  REQUIRE(table.columns.size() == 6);
  CHECK(table.columns[4].datatype == 6);
  CHECK(table.columns[5].offset == 20);

  binary.resize(binary.size() - 5);
  const PointTable cut = pcd(binary);
  check_points(cut, 19);
  CHECK(cut.damage == "it holds 19 of 20 points");
  CHECK(pcd(bytes_of(pcd_header("ascii", 3) + "1 2 0.5 7 8 9\n")).damage == "it holds 1 of 3 points");
}

TEST_CASE("whole numbers of 8 bytes and columns of several numbers are kept in place") {
  Bytes file = bytes_of(
      "VERSION .7\nFIELDS x y z _ timestamp\nSIZE 4 4 4 1 8\nTYPE F F F U U\nCOUNT 1 1 1 4 1\nWIDTH 1\nHEIGHT 1\n"
      "POINTS 1\nDATA binary\n");
  for (const float v : {1.0F, 2.0F, 3.0F}) append(file, v);
  append(file, std::uint32_t{0xffffffff});
  append(file, std::uint64_t{1'600'000'000'123'456'768});
  const PointTable table = pcd(file);
  CHECK(table.point_step == 24);
  CHECK(table.columns[3].count == 4);
  CHECK(table.columns[4].datatype == 8);
  CHECK(number<double>(table, 0, "timestamp") == 1'600'000'000'123'456'768.0);
}

TEST_CASE("LZF: runs, matches that reach into themselves, and damage") {
  const Bytes packed{2, 'a', 'b', 'c', 0x20 | 0, 2, 0xe0, 4, 0};  // abc, three more of it, thirteen times the last
  Bytes plain(19);
  REQUIRE(decompress_lzf(packed, plain));
  CHECK(std::string(plain.begin(), plain.end()) == "abcabc" + std::string(13, 'c'));
  Bytes small(18), large(20);
  CHECK_FALSE(decompress_lzf(packed, small));
  CHECK_FALSE(decompress_lzf(packed, large));
  CHECK_FALSE(decompress_lzf(Bytes{0x20, 5}, plain));       // from before the begin
  CHECK_FALSE(decompress_lzf(Bytes{31, 'a'}, plain));       // a run beyond the end
  CHECK_FALSE(decompress_lzf(Bytes{0, 'a', 0xe0}, plain));  // cut inside a match
}

TEST_CASE("headers of PCD files that claim what cannot be") {
  const auto refused = [](std::string header, const std::string& from, const std::string& to) {
    header.replace(header.find(from), from.size(), to);
    return data_error([&] { pcd(bytes_of(header)); });
  };
  const std::string header = pcd_header("binary", 4);
  CHECK(contains(refused(header, "WIDTH 4", "WIDTH 4000000000"), "f.pcd:11: it claims 4000000000 x 1 points"));
  CHECK(contains(refused(header, "WIDTH 4", "WIDTH -4"), "f.pcd:7: WIDTH lacks a number"));
  CHECK(contains(refused(header, "POINTS 4", "POINTS 5"), "POINTS is 5, WIDTH x HEIGHT 4 x 1"));
  CHECK(contains(refused(header, "SIZE 4 4", "SIZE 3 4"), "column 'x' has numbers of 3 bytes"));
  CHECK(contains(refused(header, "SIZE 4 4", "SIZE 4"), "FIELDS names 6 columns, SIZE 5"));
  CHECK(contains(refused(header, "TYPE F", "TYPE X"), "TYPE 'X' is none of I, U, F"));
  CHECK(contains(refused(header, "COUNT 1", "COUNT 4294967295"), "makes a point larger than"));
  CHECK(contains(refused(header, "DATA binary", "DATA lzma"), "DATA 'lzma' is none of"));
  CHECK(contains(refused(header, "DATA binary\n", ""), "the file ends inside its header"));
  CHECK(contains(refused(header, "VERSION", "<html>"), "'<html>' is no line of a PCD header"));
  CHECK(contains(data_error([&] { pcd(bytes_of(pcd_header("ascii", 2) + "1 2 3 4 5 6\n1 2 three 4 5 6\n")); }),
                 "f.pcd:13: 'three' is no number of column 'z'"));
  CHECK(contains(data_error([&] { pcd(bytes_of(pcd_header("ascii", 1) + "1 2 3 4 5 256\n")); }),
                 "'256' is no number of column 'ring'"));
  Bytes file = compressed_pcd(4);
  const std::size_t head = pcd_header("binary_compressed", 4).size();
  Bytes claims = file;
  claims[head + 7] = 0x40;
  CHECK(contains(data_error([&] { pcd(claims); }), "its points take 84 bytes"));
  file.pop_back();
  CHECK(contains(data_error([&] { pcd(file); }), fmt::format("at offset {}: 87 bytes of compressed points", head)));
}

TEST_CASE("PLY files, as text and binary") {
  const std::string properties =
      "element vertex 2\nproperty float x\nproperty float y\nproperty double z\nproperty float scalar_Intensity\n"
      "property uint t\nproperty uchar ring\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const PointTable ascii = ply(
      bytes_of("ply\nformat ascii 1.0\ncomment made\n" + properties + "0 0 0.5 7 0 0\n1 2 0.5 7 1000 1\n3 0 1 2\n"));
  Bytes file = bytes_of("ply\r\nformat binary_little_endian 1.0\r\n" + properties);
  for (std::uint32_t i = 0; i < 2; ++i) {
    append(file, static_cast<float>(i));
    append(file, static_cast<float>(2 * i));
    append(file, 0.5);
    append(file, 7.0F);
    append(file, 1000 * i);
    append(file, static_cast<std::uint8_t>(i));
  }
  for (const PointTable& table : {ascii, ply(file)}) {
    check_points(table, 2);
    CHECK(number<double>(table, 1, "z") == 0.5);
    CHECK(number<float>(table, 1, "intensity") == 7);
    CHECK(table.damage.empty());
  }
  file.resize(file.size() - 1);
  CHECK(ply(file).damage == "it holds 1 of 2 points");
  const auto refused = [](const std::string& text) { return data_error([&] { ply(bytes_of(text)); }); };
  CHECK(contains(refused("pcd\n"), "its first line is not 'ply'"));
  CHECK(
      contains(refused("ply\nformat binary_big_endian 1.0\n" + properties), "neither ascii nor binary_little_endian"));
  CHECK(contains(refused("ply\nformat ascii 1.0\nelement vertex 99999999999\n"), "is no number of points up to"));
  CHECK(contains(refused("ply\nformat ascii 1.0\nelement face 3\n"), "its first element is 'face'"));
  CHECK(contains(refused("ply\nformat ascii 1.0\nelement vertex 3\nproperty list uchar int x\n"), "of type 'list'"));
  CHECK(contains(refused("ply\nformat ascii 1.0\nelement vertex 3\nend_header\n"), "no element 'vertex' with"));
  CHECK(contains(refused("ply\nformat ascii 1.0\n"), "no line 'end_header'"));
}

TEST_CASE("columns are declared by name and type") {
  const FileColumns columns = declared_columns("x y z intensity:u8, time:f64 ring:u16", "here");
  CHECK(columns.point_step() == 12 + 1 + 8 + 2);
  CHECK(columns.all()[4].offset == 13);
  CHECK(contains(data_error([] { declared_columns("x y:f16 z", "here"); }),
                 "here: 'y:f16' in `scan_columns: x y:f16 z`"));
  CHECK(contains(data_error([] { declared_columns(" ,", "here"); }), "names no column"));
  PointTable table;
  parse_bin(Bytes(50), columns, table);
  CHECK(table.bytes.size() == 46);
  CHECK(table.damage == "the file ends inside a point");
}

TEST_CASE("numbers keep their nanoseconds") {
  const auto ns = [](const std::string& text, int power) { return Decimal::parse(text).value().times_power(power); };
  CHECK(ns("1600000000.123456789", 9) == 1'600'000'000'123'456'789);
  CHECK(ns("1.600000000123456789e+09", 9) == 1'600'000'000'123'456'789);
  CHECK(ns("1600000000123456789", 0) == 1'600'000'000'123'456'789);
  CHECK(ns("1600000000123456", 3) == 1'600'000'000'123'456'000);
  CHECK(ns("0.0000000005", 9) == 1);
  CHECK(ns("-2.5", 3) == -2500);
  CHECK_FALSE(ns("16000000001234567890", 0).has_value());
  CHECK_FALSE(ns("1e300", 9).has_value());
  CHECK(ns("1e-300", 9) == 0);
  for (const std::string text : {"", "-", ".", "1e", "1.2.3", "12a", "0x10", "nan", "1e999999"}) {
    CHECK_FALSE(Decimal::parse(text).has_value());
  }
}

}  // namespace aslio::io::test
