#include "aslio/statistics/order.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace aslio::statistics {

std::optional<double> quantile_of_sorted(std::span<const double> sorted, double q) {
  if (sorted.empty()) return std::nullopt;
  const double at = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(below);
  if (share == 0 || sorted[below] == sorted[below + 1]) return sorted[below];
  // Not a + share * (b - a): that is NaN for a = -inf.
  return (1 - share) * sorted[below] + share * sorted[below + 1];
}

std::optional<double> quantile(std::span<const double> values, double q) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return quantile_of_sorted(sorted, q);
}

std::optional<double> median(std::span<const double> values) { return quantile(values, 0.5); }

}  // namespace aslio::statistics
