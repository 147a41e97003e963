/// Quantiles against NumPy, intervals against what they promise.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "aslio/statistics/bootstrap.hpp"
#include "aslio/statistics/order.hpp"

using namespace aslio::statistics;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// Sums of twelve, which come near a normal distribution.
double bell(std::mt19937_64& engine) {
  double sum = -6;
  for (int k = 0; k < 12; ++k) sum += std::ldexp(static_cast<double>(engine() >> 11U), -53);
  return sum;
}

}  // namespace

TEST_CASE("quantiles are those of NumPy") {
  const std::vector<double> values = {3, 1, 4, 1, 5, 9, 2, 6};
  const std::vector<std::pair<double, double>> expected = {{0, 1},     {0.1, 1},   {0.25, 1.75},
                                                           {0.5, 3.5}, {0.9, 6.9}, {1, 9}};
  for (const auto& [q, value] : expected) {
    INFO(q);
    CHECK(*quantile(values, q) == Approx(value).epsilon(1e-14));
  }
  CHECK(median(std::vector<double>{7}) == 7.0);
  CHECK_FALSE(median({}).has_value());
}

TEST_CASE("a median next to a failure is a failure") {
  CHECK(median(std::vector<double>{1, kInf}) == kInf);
  CHECK(median(std::vector<double>{1, 2, kInf}) == 2.0);
  CHECK(median(std::vector<double>{1, kInf, kInf}) == kInf);
  CHECK(median(std::vector<double>{kInf, kInf}) == kInf);
}

TEST_CASE("the interval of a median holds the true one as often as it says") {
  std::mt19937_64 engine(7);
  int held = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> sample(30);
    for (double& value : sample) value = bell(engine);
    const auto interval = bootstrap_median(sample, {.resamples = 400, .level = 0.95, .seed = 1});
    REQUIRE(interval.has_value());
    held += interval->low <= 0 && interval->high >= 0 ? 1 : 0;
  }
  // 95 %, with three standard errors of 400 trials either way.
  CHECK(held >= 0.95 * kTrials - 13);
  CHECK(held <= 0.95 * kTrials + 13);
}

TEST_CASE("the interval depends on values and seed alone, and needs five values") {
  const std::vector<double> values = {5, 3, 8, 1, 9, 2, 7};
  const auto one = bootstrap_median(values), two = bootstrap_median(values);
  REQUIRE(one.has_value());
  CHECK(one->low == two->low);
  CHECK(one->high == two->high);
  CHECK(one->low == 2);  // frozen: the same on every machine
  CHECK(one->high == 8);
  CHECK_FALSE(bootstrap_median(std::vector<double>{1, 2, 3, 4}).has_value());
  const auto failed = bootstrap_median(std::vector<double>{1, 2, 3, kInf, kInf});
  CHECK(failed->low == 1);
  CHECK(failed->high == kInf);
}

TEST_CASE("clusters that differ widen the interval as values that differ do not") {
  // Two sequences far apart, each with hardly any spread.
  std::vector<std::vector<double>> clusters(4);
  std::vector<double> all;
  for (std::size_t c = 0; c < 4; ++c) {
    for (int k = 0; k < 25; ++k) clusters[c].push_back(static_cast<double>(c) + 0.001 * k);
    all.insert(all.end(), clusters[c].begin(), clusters[c].end());
  }
  const auto flat = bootstrap_median(all), clustered = bootstrap_median_clustered(clusters);
  REQUIRE((flat && clustered));
  CHECK(flat->low > 1);
  CHECK(flat->high < 2.1);
  CHECK(clustered->low < 1);
  CHECK(clustered->high > 2.5);
  const std::vector<std::vector<double>> single = {all, {}};
  CHECK(bootstrap_median_clustered(single)->low == flat->low);
  CHECK_FALSE(bootstrap_median_clustered(std::vector<std::vector<double>>{{1, 2}, {3}}).has_value());
}
