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

std::optional<TimeNs> parse_time(std::string_view text, TimeUnit unit) {
  const std::optional<TimeNs> t = aslio::parse_time(text, digits_of(unit));
  return t && is_time(*t) ? t : std::nullopt;
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
