#pragma once
/// Median and quantiles. Infinite values are values: a failed run counts as worse than any figure.

#include <optional>
#include <span>

namespace aslio::statistics {

/// Quantile `q` in [0, 1], linear between the order statistics (type 7 of Hyndman and Fan; NumPy's default). Between
/// two neighbours of which one is infinite it is infinite. Nothing for no values. Pre: no NaN.
std::optional<double> quantile(std::span<const double> values, double q);
/// The quantile 0.5.
std::optional<double> median(std::span<const double> values);
/// The same of values that are sorted ascending.
std::optional<double> quantile_of_sorted(std::span<const double> sorted, double q);

}  // namespace aslio::statistics
