#pragma once
/// The columns of a file of points, whatever its format says of them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "folder_recording.hpp"

namespace aslio::io {

enum class NumberKind : std::uint8_t { whole, natural, real };  ///< signed, unsigned, floating point

struct FileColumn {
  std::string name;
  NumberKind kind = NumberKind::real;
  std::uint32_t size = 4, count = 1;  ///< bytes of a number; numbers of a point
  std::uint32_t offset = 0;
};

class FileColumns {
 public:
  /// Behind those before it. Empty, or what is wrong with it.
  std::string add(FileColumn column);

  const std::vector<FileColumn>& all() const { return columns_; }
  std::uint32_t point_step() const { return step_; }  ///< bytes of a point
  std::uint32_t numbers() const { return numbers_; }  ///< of a point
  /// Columns and step of a table; whole numbers of 8 bytes become float64, for no message has such.
  void describe(PointTable& table) const;
  /// The points of a table whose bytes are as in the file.
  void convert(PointTable& table) const;
  /// Writes the numbers of one line to a point. Empty, or what is wrong with it.
  std::string write_line(std::string_view line, std::uint8_t* point) const;

 private:
  std::vector<FileColumn> columns_;
  std::uint32_t step_ = 0, numbers_ = 0;
};

/// From a declaration like `x y z intensity time ring:u16`: names in their order, float32 where no type is named (f32,
/// f64, i8 to i64, u8 to u64). Throws DataError that names `where`.
FileColumns declared_columns(std::string_view text, const std::string& where);

/// Points that may be in memory at once.
inline constexpr std::uint64_t kMaxFilePoints = 1U << 26U;
inline constexpr std::uint64_t kMaxScanBytes = 512U << 20U;

}  // namespace aslio::io
