// Choosing some of many (aslio/core/spread.hpp).
#include <array>
#include <catch2/catch.hpp>

#include "aslio/core/spread.hpp"

using namespace aslio;

TEST_CASE("one of each run: the runs are equal to within one item, cover everything, and each has its one") {
  for (const std::size_t n : {1, 2, 7, 999, 5000, 5001, 12345, 100000}) {
    for (const std::size_t taken : {1, 2, 6, 7, 998, 4999, 5000, 12345}) {
      if (taken > n) continue;
      CAPTURE(n, taken);
      for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{3}, ~std::uint64_t{0}}) {
        StratifiedPick choice(taken, n, seed);
        bool right = true;
        for (std::size_t k = 0; k < taken; ++k) {
          const std::size_t begin = k * n / taken, end = (k + 1) * n / taken;
          const std::size_t expected = end - begin == 1 ? begin : begin + mixed(seed + k) % (end - begin);
          right &= choice.next() == expected;
        }
        REQUIRE(right);
      }
    }
  }
}

TEST_CASE("one of each run: scan lines that interleave are all seen, whatever the stride") {
  constexpr std::size_t lines = 6;
  for (const std::size_t stride : {2, 3, 6, 12}) {
    CAPTURE(stride);
    constexpr std::size_t taken = 6000;
    StratifiedPick choice(taken, stride * taken, 7);
    std::array<std::size_t, lines> seen{};
    for (std::size_t k = 0; k < taken; ++k) ++seen[choice.next() % lines];
    for (const std::size_t count : seen) {
      REQUIRE(count > 850);
      REQUIRE(count < 1150);
    }
  }
}
