#include "aslio/evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace aslio::evaluation {

namespace {

/// The value that halves the total weight; between two values when the half falls between them. eq. EVAL-7
double weighted_median(std::span<const double> values, std::span<const double> weights, double total) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  double below = 0.0;
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    below += weights[order[i]];
    if (2.0 * below == total) return 0.5 * (values[order[i]] + values[order[i + 1]]);
    if (2.0 * below > total) return values[order[i]];
  }
  return values[order.back()];
}

}  // namespace

Statistics weighted_statistics(std::span<const double> values, std::span<const double> weights) {
  Statistics s;
  if (values.empty()) return s;
  s.n = values.size();
  double total = 0.0, sum = 0.0, squares = 0.0, deviations = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    total += weights[i];
    sum += weights[i] * values[i];
    squares += weights[i] * values[i] * values[i];
  }
  s.mean = sum / total;
  s.rmse = std::sqrt(squares / total);
  for (std::size_t i = 0; i < values.size(); ++i) {
    deviations += weights[i] * (values[i] - s.mean) * (values[i] - s.mean);
  }
  s.std = std::sqrt(deviations / total);
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  s.min = *min;
  s.max = *max;
  s.median = weighted_median(values, weights, total);
  return s;
}

std::vector<double> time_weights(std::span<const PosePair> pairs, TimeNs max_gap) {
  if (pairs.size() < 2) return std::vector<double>(pairs.size(), 1.0);
  std::vector<double> weights(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const double half = 0.5 * to_seconds(std::min(pairs[i].t - pairs[i - 1].t, max_gap));
    weights[i - 1] += half;
    weights[i] += half;
  }
  return weights;
}

}  // namespace aslio::evaluation
