#pragma once

#include <string>
#include <string_view>

#include "aslio/config/binder.hpp"

namespace aslio::config {

bool admits(const Range& range, double value);
/// "[0.001, 10] s", "> 0 m", "any" without limits.
std::string range_text(const Range& range, std::string_view unit);
/// " [s]", or nothing for a pure number.
std::string unit_text(std::string_view unit);

}  // namespace aslio::config
