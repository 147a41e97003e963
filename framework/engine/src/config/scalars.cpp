#include "scalars.hpp"

#include <fmt/core.h>

#include <array>
#include <charconv>
#include <cmath>

namespace aslio::config {
namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

std::size_t digits(std::string_view text) {
  std::size_t n = 0;
  while (n < text.size() && digit(text[n])) ++n;
  return n;
}

/// Without the sign; "+" is legal YAML but not legal for from_chars.
std::string_view unsigned_part(std::string_view text) {
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) text.remove_prefix(1);
  return text;
}

bool leading_zero(std::string_view text) { return text.size() > 1 && text[0] == '0' && digit(text[1]); }

bool looks_real(std::string_view text) {
  text = unsigned_part(text);
  if (leading_zero(text)) return false;
  const std::size_t whole = digits(text);
  text.remove_prefix(whole);
  std::size_t fraction = 0;
  if (!text.empty() && text.front() == '.') {
    text.remove_prefix(1);
    fraction = digits(text);
    text.remove_prefix(fraction);
  }
  if (whole + fraction == 0) return false;
  if (text.empty()) return true;
  if (text.front() != 'e' && text.front() != 'E') return false;
  text = unsigned_part(text.substr(1));
  return !text.empty() && digits(text) == text.size();
}

template <class T>
std::optional<T> convert(std::string_view text) {
  if (text.front() == '+') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> parse_real(std::string_view text) {
  if (!looks_real(text)) return std::nullopt;
  const auto value = convert<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  const std::string_view magnitude = unsigned_part(text);
  if (magnitude.empty() || digits(magnitude) != magnitude.size() || leading_zero(magnitude)) return std::nullopt;
  return convert<std::int64_t>(text);
}

std::string format_real(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return error == std::errc() ? std::string(buffer.data(), end) : std::string();
}

std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      constexpr std::string_view kHex = "0123456789abcdef";
      result += {'\\', 'x', kHex[byte >> 4U], kHex[byte & 15U]};
    } else {
      result += c;
    }
  }
  return result;
}

std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 80;
  return fmt::format("'{}{}'", printable(text.substr(0, kLongest)), text.size() > kLongest ? ".." : "");
}

}  // namespace aslio::config
