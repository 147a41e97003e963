/// Against numbers of scipy.stats.wilcoxon 1.10.1 and of the definitions.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "aslio/statistics/signed_rank.hpp"

using namespace aslio::statistics;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<double> alternating(int count) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back((k / 3 % 2 == 0 ? 1 : -1) * (k + 1.0));
  return out;
}

}  // namespace

TEST_CASE("few differences without ties have the p-value of the exact distribution") {
  const std::vector<double> differences = {0.12, -0.03, 0.25, 0.31, -0.08, 0.17, 0.22, 0.05};
  const SignedRank eight = signed_rank(differences);
  CHECK(eight.exact);
  CHECK(eight.positive == 6);
  CHECK(eight.negative == 2);
  CHECK(eight.rank_sum_negative == 4);
  REQUIRE(eight.p.has_value());
  CHECK(*eight.p == Approx(0.0546875).epsilon(1e-12));
  CHECK(*eight.effect == Approx((32.0 - 4.0) / 36.0));
  CHECK(*signed_rank(std::vector<double>{1, 2, 3, 4, 5, 6}).p == 0.03125);
  CHECK(*signed_rank(std::vector<double>{1, 2, 3, -4, -5, -6.5}).p == Approx(0.4375).epsilon(1e-12));
  CHECK(*signed_rank(std::vector<double>{1, 2, -3, 4, -5, 6, 7}).p == Approx(0.375).epsilon(1e-12));
  const SignedRank most = signed_rank(alternating(25));
  CHECK(most.exact);
  CHECK(*most.p == Approx(0.8948604464530945).epsilon(1e-12));
  CHECK_FALSE(signed_rank(alternating(26)).exact);
}

TEST_CASE("few differences with ties and zeros have that of their own ranks, which no signs fall below") {
  const SignedRank tied = signed_rank(std::vector<double>{1, 1, 2, -2, 3, 3, -1, 0, 0, 4, 5, -1});
  CHECK(tied.exact);
  CHECK(tied.zero == 2);
  CHECK(tied.rank_sum_negative == 10.5);
  CHECK(*tied.p == 100.0 / 1024);  // by counting all signs; the normal approximation has 0.0901
  // A method that fails nowhere against a baseline that fails everywhere.
  for (int n = 6; n <= 25; ++n) {
    CHECK(*signed_rank(std::vector<double>(static_cast<std::size_t>(n), -kInf)).p == std::ldexp(2.0, -n));
  }
}

TEST_CASE("many differences have that of the normal approximation, corrected for ties") {
  const std::vector<double> ties = {1, 1, 2, -2, 3,  3, -1, 4, 5,  -1, 6, 6, -6,
                                    7, 8, 9, -9, 10, 3, 3,  1, -2, 2,  5, 5, 4};
  CHECK_FALSE(signed_rank(ties).exact);
  CHECK(*signed_rank(ties).p == Approx(0.005324748138486117).epsilon(1e-12));
  std::vector<double> many;
  for (int k = 0; k < 40; ++k) many.push_back(((k * 37) % 61 - 25) / 10.0 + 0.01 * k);
  CHECK(*signed_rank(many).p == Approx(0.05895855320140442).epsilon(1e-12));
}

TEST_CASE("below six pairs there is no p-value, and without a difference it is 1") {
  const SignedRank five = signed_rank(std::vector<double>{1, 2, 3, 4, 5});
  CHECK_FALSE(five.p.has_value());
  CHECK(five.effect == 1.0);
  const SignedRank none = signed_rank(std::vector<double>(6, 0.0));
  CHECK(none.p == 1.0);
  CHECK_FALSE(none.effect.has_value());
  CHECK_FALSE(signed_rank({}).p.has_value());
}

TEST_CASE("an infinite difference has the largest rank, whatever else there is") {
  const SignedRank failed = signed_rank(std::vector<double>{-1, -2, -3, -4, -5, kInf});
  CHECK(failed.rank_sum_positive == 6);
  CHECK(failed.exact);
  CHECK(failed.p == signed_rank(std::vector<double>{-1, -2, -3, -4, -5, 600}).p);
  CHECK(signed_rank(std::vector<double>{1, 2, 3, 4, kInf, kInf}).rank_sum_positive == 21);
  CHECK(signed_rank(std::vector<double>{1, 2, 3, 4, kInf, -kInf}).rank_sum_negative == 5.5);
}

TEST_CASE("Holm's correction steps down from the smallest") {
  const std::vector<std::optional<double>> p = {0.01, std::nullopt, 0.04, 0.03, 0.005};
  const auto corrected = holm(p);
  CHECK(*corrected[0] == Approx(0.03));
  CHECK_FALSE(corrected[1].has_value());
  CHECK(*corrected[2] == Approx(0.06));  // not below that of 0.03
  CHECK(*corrected[3] == Approx(0.06));
  CHECK(*corrected[4] == Approx(0.02));
  CHECK(*holm(std::vector<std::optional<double>>{0.7, 0.9})[0] == 1);
  CHECK(holm({}).empty());
}
