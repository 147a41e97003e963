#include "stamps.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "aslio/io/writers.hpp"

namespace aslio::io {
namespace {

/// Decimal digits of a unit below which are nanoseconds.
int digits_of(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::ms:
      return 6;
    case TimeUnit::us:
      return 3;
    case TimeUnit::ns:
      return 0;
    case TimeUnit::automatic:
    case TimeUnit::s:
      break;
  }
  return 9;
}

/// Words of a name: `timestamp [ns]` has timestamp and ns.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || (lower >= '0' && lower <= '9')) {
      words.back() += lower;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  return words;
}

std::optional<TimeUnit> unit_in(std::string_view header) {
  for (const std::string& word : words_of(header)) {
    if (word == "ns" || word == "nsec" || word == "nanoseconds" || word == "nanosec") return TimeUnit::ns;
    if (word == "us" || word == "usec" || word == "microseconds") return TimeUnit::us;
    if (word == "ms" || word == "msec" || word == "milliseconds") return TimeUnit::ms;
    if (word == "s" || word == "sec" || word == "seconds" || word == "secs") return TimeUnit::s;
  }
  return std::nullopt;
}

/// Unit in which a time since 1970 is of this size.
std::optional<TimeUnit> epoch_unit(double value) {
  double least = 5e8;
  for (const TimeUnit unit : {TimeUnit::s, TimeUnit::ms, TimeUnit::us, TimeUnit::ns}) {
    if (value >= least && value <= 9.2 * least) return unit;
    least *= 1e3;
  }
  return std::nullopt;
}

/// Median step of the stamps that differ; 0 where none do.
double usual_step(std::span<const std::string_view> stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const auto before = parse_number(stamps[i - 1]), now = parse_number(stamps[i]);
    if (before && now && *now > *before) steps.push_back(*now - *before);
  }
  if (steps.empty()) return 0;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

}  // namespace

const char* name(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::ms:
      return "ms";
    case TimeUnit::us:
      return "us";
    case TimeUnit::ns:
      return "ns";
    case TimeUnit::automatic:
    case TimeUnit::s:
      break;
  }
  return "s";
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

std::optional<TimeNs> parse_time(std::string_view text, TimeUnit unit) {
  constexpr int kMaxExponent = 40;
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t e = std::min(text.find_first_of("eE"), text.size());
  int point = digits_of(unit);  // where the decimal point goes, from where it stands
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
    if (error != std::errc{} || t > kFarthestTime) return {};
  }
  t += round_up ? 1 : 0;
  if (!is_time(t)) return {};
  return negative ? -t : t;
}

std::optional<UnitVerdict> judge_unit(std::span<const std::string_view> stamps, std::string_view header) {
  const double step = usual_step(stamps);
  if (!stamps.empty()) {
    // Nanoseconds since a start are of the size of seconds since 1970, but years apart if they were.
    constexpr double kLongest = 3600;
    const auto value = parse_number(stamps.front());
    const auto epoch = value ? epoch_unit(std::abs(*value)) : std::nullopt;
    if (epoch && step <= kLongest * std::pow(10, 9 - digits_of(*epoch))) return UnitVerdict{*epoch, "by their size"};
  }
  if (const auto written = unit_in(header)) return UnitVerdict{*written, "by the header"};
  const bool fractions = std::any_of(stamps.begin(), stamps.end(),
                                     [](std::string_view stamp) { return stamp.find('.') != std::string_view::npos; });
  constexpr double kLongestSeconds = 2, kShortestNanoseconds = 5e5;
  if (fractions || step <= kLongestSeconds) return UnitVerdict{TimeUnit::s, "by their steps"};
  if (step >= kShortestNanoseconds) return UnitVerdict{TimeUnit::ns, "by their steps"};
  return std::nullopt;
}

}  // namespace aslio::io
