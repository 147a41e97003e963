#include "aslio/core/parse.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace aslio {

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

std::optional<TimeNs> parse_time(std::string_view text, int nanosecond_digits) {
  constexpr int kMaxExponent = 40;
  constexpr TimeNs kFarthest = kTimeMax / 2;
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t e = std::min(text.find_first_of("eE"), text.size());
  int point = nanosecond_digits;  // where the decimal point goes, from where it stands
  if (e < text.size()) {
    std::string_view exponent = text.substr(e + 1);
    if (exponent.starts_with('+')) exponent.remove_prefix(1);
    int value = 0;
    const auto [end, error] = std::from_chars(exponent.data(), exponent.data() + exponent.size(), value);
    if (error != std::errc{} || end != exponent.data() + exponent.size() || std::abs(value) > kMaxExponent) return {};
    point += value;
  }
  const std::size_t dot = std::min(text.find('.'), e);
  std::string digits(text.substr(0, dot));
  point += static_cast<int>(std::min<std::size_t>(digits.size(), 1000));
  if (dot < e) digits.append(text.substr(dot + 1, e - dot - 1));
  if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos) return {};
  const std::size_t first = std::min(digits.find_first_not_of('0'), digits.size());
  digits.erase(0, first);
  point -= static_cast<int>(std::min<std::size_t>(first, 1000));
  if (digits.empty() || point < 0) return TimeNs{0};
  if (point > 19) return {};
  const auto count = static_cast<std::size_t>(point);
  const bool round_up = digits.size() > count && digits[count] >= '5';
  digits.resize(count, '0');
  TimeNs t = 0;
  if (count > 0) {
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + count, t);
    if (error != std::errc{} || t > kFarthest) return {};
  }
  t += round_up ? 1 : 0;
  if (t > kFarthest) return {};
  return negative ? -t : t;
}

}  // namespace aslio
