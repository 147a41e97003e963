#pragma once
/// Numbers by our own rules: yaml-cpp reads 010 as 8 and .nan as a number.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace aslio::config {

/// A finite decimal number: [+-] digits without a leading zero, fraction, exponent. Nothing when the text is none.
std::optional<double> parse_real(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);
/// Shortest text that reads back to the same number.
std::string format_real(double value);
/// Control characters as \\xNN: they could command the terminal.
std::string printable(std::string_view text);
/// Text for a message: control characters escaped, long text cut, in single quotes.
std::string quote(std::string_view text);

}  // namespace aslio::config
