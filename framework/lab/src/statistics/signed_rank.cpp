#include "aslio/statistics/signed_rank.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace aslio::statistics {

namespace {

struct Ranks {
  std::vector<double> of;  ///< by difference
  double ties = 0;         ///< sum of t^3 - t over the groups of t equal ones
};

/// Mean ranks of absolute values, from 1.
Ranks ranks_of(const std::vector<double>& differences) {
  std::vector<std::size_t> order(differences.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto size = [&](std::size_t i) { return std::abs(differences[i]); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) < size(b); });
  Ranks ranks{.of = std::vector<double>(differences.size()), .ties = 0};
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && size(order[end]) == size(order[begin])) ++end;
    for (std::size_t k = begin; k < end; ++k) ranks.of[order[k]] = 0.5 * static_cast<double>(begin + 1 + end);
    const auto t = static_cast<double>(end - begin);
    ranks.ties += t * t * t - t;
    begin = end;
  }
  return ranks;
}

/// Probability of a rank sum as far from the middle as this, among all 2^n signs of these ranks.
double exact_p(double rank_sum, const std::vector<double>& ranks) {
  const std::size_t n = ranks.size();
  // Twice the ranks are whole numbers, ties among them. ways[s]: subsets with sum s.
  std::vector<double> ways(n * (n + 1) + 1, 0.0);
  ways[0] = 1;
  for (const double rank : ranks) {
    const auto step = static_cast<std::size_t>(2 * rank);
    for (std::size_t s = ways.size(); s-- > step;) ways[s] += ways[s - step];
  }
  const double sum = 2 * rank_sum;
  const auto smaller = static_cast<std::size_t>(std::min(sum, static_cast<double>(ways.size() - 1) - sum));
  const double below = std::accumulate(ways.begin(), ways.begin() + static_cast<std::ptrdiff_t>(smaller) + 1, 0.0);
  return std::min(1.0, 2 * below * std::ldexp(1.0, -static_cast<int>(n)));
}

double normal_p(double rank_sum, double n, double ties) {
  const double mean = n * (n + 1) / 4;
  const double deviation = std::sqrt((n * (n + 1) * (2 * n + 1) - 0.5 * ties) / 24);
  if (deviation == 0) return 1;
  const double distance = std::max(0.0, std::abs(rank_sum - mean) - 0.5);
  return std::erfc(distance / deviation / std::numbers::sqrt2);
}

}  // namespace

SignedRank signed_rank(std::span<const double> differences) {
  SignedRank out;
  std::vector<double> counted;
  for (const double d : differences) {
    if (d != 0) counted.push_back(d);
  }
  out.zero = differences.size() - counted.size();
  const Ranks ranks = ranks_of(counted);
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const bool up = counted[i] > 0;
    ++(up ? out.positive : out.negative);
    (up ? out.rank_sum_positive : out.rank_sum_negative) += ranks.of[i];
  }
  const double all = out.rank_sum_positive + out.rank_sum_negative;
  if (all > 0) out.effect = (out.rank_sum_positive - out.rank_sum_negative) / all;
  if (differences.size() < kMinPairs) return out;
  const std::size_t n = counted.size();
  out.exact = n <= kMaxExact;
  if (n == 0) {
    out.p = 1;
  } else if (out.exact) {
    out.p = exact_p(out.rank_sum_positive, ranks.of);
  } else {
    out.p = normal_p(out.rank_sum_positive, static_cast<double>(n), ranks.ties);
  }
  return out;
}

std::vector<std::optional<double>> holm(std::span<const std::optional<double>> p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i]) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return *p[a] < *p[b]; });
  std::vector<std::optional<double>> out(p.size());
  double largest = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(order.size() - k) * *p[order[k]]));
    out[order[k]] = largest;
  }
  return out;
}

}  // namespace aslio::statistics
