#include "ranges.hpp"

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
  std::string text;
  if (std::isfinite(low) && std::isfinite(high)) {
    text = (open_low ? "(" : "[") + format_real(low) + ", " + format_real(high) + (open_high ? ")" : "]");
  } else if (std::isfinite(low)) {
    text = (open_low ? "> " : ">= ") + format_real(low);
  } else if (std::isfinite(high)) {
    text = (open_high ? "< " : "<= ") + format_real(high);
  } else {
    return "any";
  }
  return unit.empty() ? text : text + ' ' + std::string(unit);
}

std::string unit_text(std::string_view unit) { return unit.empty() ? "" : " [" + std::string(unit) + "]"; }

}  // namespace aslio::config
