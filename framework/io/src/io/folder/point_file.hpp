#pragma once
/// Files of points, read whole and checked: nothing that a header claims is believed before the bytes are there.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "file_columns.hpp"
#include "folder_recording.hpp"

namespace aslio::io {

using FileBytes = std::span<const std::uint8_t>;

/// Point Cloud Data 0.6 and 0.7: ascii, binary, binary_compressed. `where` names the file in errors. Throws DataError
/// with the line or offset. A file that ends early yields its whole points and says so in `damage`.
void parse_pcd(FileBytes file, const std::string& where, PointTable& table);

/// Polygon File Format: ascii, binary_little_endian; vertices alone. As parse_pcd().
void parse_ply(FileBytes file, const std::string& where, PointTable& table);

/// Numbers of these columns, point after point.
void parse_bin(FileBytes file, const FileColumns& columns, PointTable& table);

/// Of a .pcd, .ply or .bin file; `bin` are the columns of the latter. Throws DataError.
void read_point_file(const std::filesystem::path& path, const FileColumns& bin, PointTable& table);

/// Decompresses LZF (Lehmann): fills `to`; false where the data are damaged or do not fill it.
bool decompress_lzf(FileBytes from, std::span<std::uint8_t> to);

/// Lines of a text with their numbers, without their line feeds.
class TextLines {
 public:
  explicit TextLines(FileBytes text)
      : left_(reinterpret_cast<const char*>(text.data()), text.size()), all_(text.size()) {}
  /// False at the end.
  bool next(std::string_view& line);
  std::size_t number() const { return number_; }              ///< of the line last read, from 1
  std::size_t offset() const { return all_ - left_.size(); }  ///< of the line to come

 private:
  std::string_view left_;
  std::size_t all_, number_ = 0;
};

/// `points` lines of numbers behind a header.
void read_ascii_points(TextLines& lines, const FileColumns& columns, std::uint64_t points, const std::string& where,
                       PointTable& table);
/// `points` points behind a header.
void take_binary_points(FileBytes data, const FileColumns& columns, std::uint64_t points, PointTable& table);

}  // namespace aslio::io
