#pragma once
/// Percentile bootstrap of medians. Efron and Tibshirani, An Introduction to the Bootstrap (1993), ch. 13.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace aslio::statistics {

/// The interval of fewer values would promise more than it holds: between the extremes of 5 the median lies with 94 %.
inline constexpr std::size_t kMinForInterval = 5;

struct Interval {
  double low = 0, high = 0;
};

struct BootstrapOptions {
  int resamples = 2000;
  double level = 0.95;
  std::uint64_t seed = 1;  ///< the same values in the same order give the same interval, on every machine
};

/// Interval of the median of one sample. Nothing below kMinForInterval values.
std::optional<Interval> bootstrap_median(std::span<const double> values, const BootstrapOptions& options = {});

/// Interval of the median of all values where they come in clusters (sequences): clusters are drawn with replacement,
/// then values inside each. Of one cluster it is that of bootstrap_median(). Nothing below kMinForInterval values.
std::optional<Interval> bootstrap_median_clustered(std::span<const std::vector<double>> clusters,
                                                   const BootstrapOptions& options = {});

}  // namespace aslio::statistics
