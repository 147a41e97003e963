// How many matches share a surface, against a count in a map.
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <span>
#include <vector>

#include "aslio/toolkit/match_tally.hpp"

using namespace aslio;

TEST_CASE("matches are counted by the surface they lie on, for few surfaces and for more than the first table takes") {
  std::mt19937_64 engine(3);
  std::vector<double> places(20000);  // whose addresses stand for surfaces
  MatchTally tally;
  for (const std::size_t surfaces : {1UL, 7UL, 400UL, 600UL, 20000UL, 50UL}) {
    CAPTURE(surfaces);
    std::vector<Surface> matches(8000);
    std::map<const void*, std::uint32_t> expected;
    for (Surface& match : matches) {
      const auto what = engine() % 10;
      match.valid = what != 0;
      if (what != 1) match.owner = &places[engine() % surfaces];
      if (match.valid && match.owner != nullptr) ++expected[match.owner];
    }
    const double times = static_cast<double>(surfaces % 4) + 1.0;
    tally.count(matches, times);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const bool owned = matches[i].valid && matches[i].owner != nullptr;
      REQUIRE(matches[i].shared_matches == times * (owned ? expected[matches[i].owner] : 1));
    }
  }
}

TEST_CASE("no matches at all may be counted") {
  MatchTally tally;
  tally.count(std::span<Surface>());
  std::vector<Surface> one(1);
  tally.count(one);
  CHECK(one[0].shared_matches == 1.0);
}

TEST_CASE("sets that are registered together are counted as one") {
  const double places[3] = {};
  std::vector<Surface> all(30);
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = {.valid = i % 7 != 0, .owner = i % 5 == 0 ? nullptr : &places[i % 3]};
  std::vector<Surface> first(all.begin(), all.begin() + 11), none, last(all.begin() + 11, all.end());
  MatchTally tally;
  tally.count(all, 0.5);
  const std::span<Surface> sets[] = {first, none, last};
  tally.count(sets, 0.5);
  for (std::size_t i = 0; i < all.size(); ++i)
    CHECK((i < 11 ? first[i] : last[i - 11]).shared_matches == all[i].shared_matches);
}
