#include "ranges.hpp"

#include <fmt/core.h>

#include <cmath>

#include "scalars.hpp"

namespace aslio::config {

bool admits(const Range& range, double value) {
  return value >= range.min && value > range.above && value <= range.max && value < range.below;
}

std::string range_text(const Range& range, std::string_view unit) {
  const bool open_low = range.above >= range.min;
  const bool open_high = range.below <= range.max;
  const double low = open_low ? range.above : range.min;
  const double high = open_high ? range.below : range.max;
  std::string text = "any";
  if (std::isfinite(low) && std::isfinite(high)) {
    text = fmt::format("{}{}, {}{}", open_low ? '(' : '[', format_real(low), format_real(high), open_high ? ')' : ']');
  } else if (std::isfinite(low)) {
    text = fmt::format("{} {}", open_low ? ">" : ">=", format_real(low));
  } else if (std::isfinite(high)) {
    text = fmt::format("{} {}", open_high ? "<" : "<=", format_real(high));
  } else {
    return text;
  }
  return unit.empty() ? text : fmt::format("{} {}", text, unit);
}

std::string unit_text(std::string_view unit) { return unit.empty() ? std::string() : fmt::format(" [{}]", unit); }

}  // namespace aslio::config
