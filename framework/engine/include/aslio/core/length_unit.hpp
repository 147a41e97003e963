#pragma once
/// The unit of lengths for people: the same in the terminal, in tables and in the report.

#include <cmath>
#include <string_view>

namespace aslio {

struct LengthUnit {
  double scale = 1;  ///< from metres
  std::string_view name = "m";
};

/// Millimetres where the largest of the lengths [m] is below 0.1 m, else metres. One unit serves a whole table.
inline LengthUnit length_unit(double largest) {
  return std::abs(largest) < 0.1 ? LengthUnit{1000, "mm"} : LengthUnit{};
}

}  // namespace aslio
