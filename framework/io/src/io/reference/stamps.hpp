#pragma once
/// Times in text, exact to the nanosecond, in whatever unit.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "aslio/core/parse.hpp"
#include "aslio/io/reference.hpp"

namespace aslio::io {

/// "s", "ms", ..
const char* name(TimeUnit unit);

/// A decimal number in `unit` to ns, rounded to nearest, without passing through a double. Nothing when it is none, or
/// beyond kFarthestTime.
std::optional<TimeNs> parse_time(std::string_view text, TimeUnit unit);

/// What unit the stamps of a file are in, and how that was found.
struct UnitVerdict {
  TimeUnit unit = TimeUnit::s;
  std::string how;  ///< "by their size", "by the header", ..
};

/// By the size of stamps that count from 1970 (of 1985 to 2115), else by the word in the header, else seconds if they
/// have fractions, and nanoseconds where whole ones are 0.5 ms or more apart in those. Nothing where nothing tells.
std::optional<UnitVerdict> judge_unit(std::span<const std::string_view> stamps, std::string_view header);

}  // namespace aslio::io
