// Reads samples, one per line, and prints what the framework makes of each: for the comparison with SciPy.
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "aslio/statistics/bootstrap.hpp"
#include "aslio/statistics/order.hpp"
#include "aslio/statistics/signed_rank.hpp"

int main() {
  using namespace aslio::statistics;
  std::vector<std::optional<double>> p;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream stream(line);
    std::vector<double> values;
    for (std::string word; stream >> word;) values.push_back(std::stod(word));
    const SignedRank test = signed_rank(values);
    const auto interval = bootstrap_median(values, {.resamples = 20000, .level = 0.95, .seed = 1});
    p.push_back(test.p);
    std::printf("%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", test.exact ? 1 : 0, test.p.value_or(-1),
                test.rank_sum_positive, test.rank_sum_negative, *quantile(values, 0.25), *median(values),
                interval ? interval->low : 0, interval ? interval->high : 0);
  }
  for (const auto& corrected : holm(p)) std::printf("%.17g\n", corrected.value_or(-1));
}
