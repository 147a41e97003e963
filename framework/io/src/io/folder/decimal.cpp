#include "decimal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

namespace aslio::io {
namespace {

constexpr std::array<DecimalUnit, 4> kUnits{{{"s", 9}, {"ms", 6}, {"us", 3}, {"ns", 0}}};

double seconds(double value, const DecimalUnit& unit) { return value * std::pow(10.0, unit.power - 9); }

/// What lies between 1990 and 2100 as a time since 1970: no two units fit.
const DecimalUnit* unit_of_epoch(double value) {
  constexpr double kFrom = 6.3e8, kTo = 4.1e9;
  const auto fits = [value](const DecimalUnit& unit) {
    return seconds(value, unit) > kFrom && seconds(value, unit) < kTo;
  };
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), fits);
  return found == kUnits.end() ? nullptr : &*found;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Of text from `e` on; nullopt where it is no exponent.
std::optional<int> exponent_of(std::string_view text) {
  text.remove_prefix(1);
  if (text.starts_with('+')) text.remove_prefix(1);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  constexpr int kLargest = 400;
  if (error != std::errc{} || end != text.data() + text.size() || std::abs(value) > kLargest) return std::nullopt;
  return value;
}

}  // namespace

std::optional<Decimal> Decimal::parse(std::string_view text) {
  constexpr std::size_t kLongest = 100;
  constexpr std::uint64_t kFull = 999'999'999'999'999'999U;  // one more digit still fits
  if (text.size() > kLongest) return std::nullopt;
  Decimal number;
  number.negative = text.starts_with('-');
  if (number.negative || text.starts_with('+')) text.remove_prefix(1);
  bool point = false, any = false;
  std::size_t i = 0;
  for (; i < text.size() && (is_digit(text[i]) || (text[i] == '.' && !point)); ++i) {
    if (text[i] == '.') {
      point = true;
      continue;
    }
    any = true;
    const bool kept = number.digits <= kFull;
    if (kept) number.digits = number.digits * 10 + static_cast<std::uint64_t>(text[i] - '0');
    number.exponent += kept ? (point ? -1 : 0) : (point ? 0 : 1);
  }
  if (!any) return std::nullopt;
  if (i == text.size()) return number;
  if (text[i] != 'e' && text[i] != 'E') return std::nullopt;
  const auto exponent = exponent_of(text.substr(i));
  if (!exponent) return std::nullopt;
  number.exponent += *exponent;
  return number;
}

std::optional<std::int64_t> Decimal::times_power(int power) const {
  constexpr std::uint64_t kMost = std::numeric_limits<std::int64_t>::max();
  std::uint64_t value = digits;
  int left = exponent + power;
  for (; left > 0 && value != 0; --left) {
    if (value > kMost / 10) return std::nullopt;
    value *= 10;
  }
  bool up = false;
  for (; left < 0 && (value != 0 || up); ++left) {
    up = value % 10 >= 5;
    value /= 10;
  }
  value += up ? 1 : 0;
  if (value > kMost) return std::nullopt;
  return negative ? -static_cast<std::int64_t>(value) : static_cast<std::int64_t>(value);
}

double Decimal::value() const {
  const double magnitude = static_cast<double>(digits) * std::pow(10.0, exponent);
  return negative ? -magnitude : magnitude;
}

const DecimalUnit* judge_time_unit(std::span<const Decimal> times, double least_step, double largest_step) {
  if (times.empty()) return nullptr;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (const double step = times[i].value() - times[i - 1].value(); step > 0) steps.push_back(step);
  }
  if (steps.empty()) return unit_of_epoch(times.front().value());
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const auto fits = [&](const DecimalUnit& unit) {
    return seconds(*middle, unit) >= least_step && seconds(*middle, unit) < largest_step;
  };
  const auto found = std::find_if(kUnits.begin(), kUnits.end(), fits);
  return found == kUnits.end() ? nullptr : &*found;
}

}  // namespace aslio::io
