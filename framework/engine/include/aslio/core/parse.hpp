#pragma once
/// Numbers and times in text.

#include <optional>
#include <string_view>

#include "aslio/core/time.hpp"

namespace aslio {

/// A finite number; nothing when the text is none.
std::optional<double> parse_number(std::string_view text);

/// A decimal number to ns, rounded to nearest, without passing through a double. `nanosecond_digits` of its decimals
/// are of whole nanoseconds: 9 for seconds, 0 for nanoseconds. Nothing when it is none, or beyond half of kTimeMax.
std::optional<TimeNs> parse_time(std::string_view text, int nanosecond_digits);

}  // namespace aslio
