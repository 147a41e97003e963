#include "aslio/statistics/bootstrap.hpp"

#include <algorithm>
#include <random>

#include "aslio/statistics/order.hpp"

namespace aslio::statistics {

namespace {

/// Whole numbers below `count`. The standard fixes the engine, not the distributions.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  std::size_t below(std::size_t count) {
    // 32 bits times the count, without its low half: off from uniform by less than count / 2^32.
    return static_cast<std::size_t>(((engine_() >> 32U) * static_cast<std::uint64_t>(count)) >> 32U);
  }

 private:
  std::mt19937_64 engine_;
};

/// Reorders the values.
double median_of(std::vector<double>& values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  const double upper = *half;
  if (values.size() % 2 == 1) return upper;
  const double lower = *std::max_element(values.begin(), half);
  return lower == upper ? upper : 0.5 * lower + 0.5 * upper;
}

Interval percentiles(std::vector<double>& medians, double level) {
  std::sort(medians.begin(), medians.end());
  return {*quantile_of_sorted(medians, 0.5 * (1 - level)), *quantile_of_sorted(medians, 0.5 * (1 + level))};
}

}  // namespace

std::optional<Interval> bootstrap_median(std::span<const double> values, const BootstrapOptions& options) {
  if (values.size() < kMinForInterval) return std::nullopt;
  Draw draw(options.seed);
  std::vector<double> medians, sample(values.size());
  for (int k = 0; k < options.resamples; ++k) {
    for (double& value : sample) value = values[draw.below(values.size())];
    medians.push_back(median_of(sample));
  }
  return percentiles(medians, options.level);
}

std::optional<Interval> bootstrap_median_clustered(std::span<const std::vector<double>> clusters,
                                                   const BootstrapOptions& options) {
  std::vector<const std::vector<double>*> filled;
  std::size_t count = 0;
  for (const auto& cluster : clusters) {
    if (!cluster.empty()) filled.push_back(&cluster);
    count += cluster.size();
  }
  if (count < kMinForInterval) return std::nullopt;
  if (filled.size() == 1) return bootstrap_median(*filled.front(), options);
  Draw draw(options.seed);
  std::vector<double> medians, sample;
  for (int k = 0; k < options.resamples; ++k) {
    sample.clear();
    for (std::size_t c = 0; c < filled.size(); ++c) {
      const std::vector<double>& cluster = *filled[draw.below(filled.size())];
      for (std::size_t i = 0; i < cluster.size(); ++i) sample.push_back(cluster[draw.below(cluster.size())]);
    }
    medians.push_back(median_of(sample));
  }
  return percentiles(medians, options.level);
}

}  // namespace aslio::statistics
