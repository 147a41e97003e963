#pragma once
/// Wilcoxon's signed-rank test of paired differences, and the correction for several of them.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace aslio::statistics {

/// A p-value of fewer pairs could not fall below 0.05: there is none.
inline constexpr std::size_t kMinPairs = 6;
/// Up to so many differences that are not zero the distribution is enumerated over their ranks; beyond, the normal
/// approximation.
inline constexpr std::size_t kMaxExact = 25;

struct SignedRank {
  std::size_t positive = 0, negative = 0, zero = 0;  ///< differences by sign
  double rank_sum_positive = 0, rank_sum_negative = 0;
  /// Matched-pairs rank-biserial correlation, (W+ - W-) / (W+ + W-), in [-1, 1]; positive: differences are positive.
  /// Nothing when all are zero. Kerby, Comprehensive Psychology 3 (2014).
  std::optional<double> effect;
  /// Two-sided. Nothing below kMinPairs pairs; 1 when all differences are zero.
  std::optional<double> p;
  bool exact = false;
};

/// Zeros are left out of the ranks (Wilcoxon's way), ties share their mean rank. Infinite differences have the largest
/// rank. The approximation corrects for ties and continuity; with few ties it would fall below what any signs can
/// attain. Wilcoxon, Biometrics Bulletin 1 (1945); figures as scipy.stats.wilcoxon has them, which for few ties and
/// zeros has the approximation alone. Pre: no NaN.
SignedRank signed_rank(std::span<const double> differences);

/// Holm's step-down correction, Scand. J. Stat. 6 (1979): in the order given, at most 1. What has no p-value has none
/// afterwards, and does not count.
std::vector<std::optional<double>> holm(std::span<const std::optional<double>> p);

}  // namespace aslio::statistics
