#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "aslio/core/time.hpp"

namespace aslio::io {

/// A number as it is written, so that a time keeps its nanoseconds: digits * 10^exponent. Of more than 19 digits the
/// last are dropped.
struct Decimal {
  std::uint64_t digits = 0;
  int exponent = 0;
  bool negative = false;

  /// `-12.50`, `1.6e+09`; nullopt for anything else.
  static std::optional<Decimal> parse(std::string_view text);
  /// The number times 10^power, rounded to nearest; nullopt where it does not fit 63 bits.
  std::optional<std::int64_t> times_power(int power) const;
  double value() const;
};

/// A unit of times, as a power of ten of nanoseconds.
struct DecimalUnit {
  std::string_view name;
  int power;
};

/// The unit in which the median step between successive times lies within bounds [s]; these must be less than a factor
/// of 1000 apart, so that one unit fits at most. Times that do not step are taken for time since 1970. nullptr: none.
const DecimalUnit* judge_time_unit(std::span<const Decimal> times, double least_step, double largest_step);

}  // namespace aslio::io
