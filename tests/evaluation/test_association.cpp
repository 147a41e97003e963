#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/association.hpp"
#include "evaluation/paths.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;
using test::kMs;
using test::sampled;

Trajectory at_times(std::initializer_list<TimeNs> times) {
  Trajectory trajectory;
  for (const TimeNs t : times) trajectory.append({t, {Mat3::Identity(), Vec3(to_seconds(t), 0, 0)}});
  return trajectory;
}

std::vector<TimeNs> times_of(const std::vector<PosePair>& pairs) {
  std::vector<TimeNs> times;
  for (const PosePair& pair : pairs) times.push_back(pair.t);
  return times;
}

}  // namespace

TEST_CASE("the reference is interpolated at the estimate's stamps and what lies outside is counted") {  // eq. EVAL-1
  const Trajectory reference = at_times({1000 * kMs, 1100 * kMs, 1200 * kMs});
  const Trajectory estimate = at_times({990 * kMs, 1030 * kMs, 1100 * kMs, 1170 * kMs, 1210 * kMs});
  const Association a = associate_interpolated(estimate, reference, 100 * kMs, kSecond);
  CHECK(times_of(a.pairs) == std::vector<TimeNs>{1030 * kMs, 1100 * kMs, 1170 * kMs});
  CHECK(a.matched() == 3);
  CHECK(a.unmatched() == 2);
  CHECK(a.covered == Approx(1.0));
  for (const PosePair& pair : a.pairs) CHECK((pair.reference.p - pair.estimate.p).norm() < 1e-12);
}

TEST_CASE("gaps of the reference are not bridged, gaps of the estimate are not covered") {
  const Trajectory reference = at_times({0, 100 * kMs, 300 * kMs, 400 * kMs});
  const Trajectory estimate = at_times({50 * kMs, 200 * kMs, 350 * kMs});
  const Association a = associate_interpolated(estimate, reference, 100 * kMs, kSecond);
  CHECK(times_of(a.pairs) == std::vector<TimeNs>{50 * kMs, 350 * kMs});
  CHECK(a.covered == Approx(0.75));
  const Association strict = associate_interpolated(estimate, reference, 100 * kMs, 149 * kMs);
  CHECK(strict.covered == 0.0);

  const Trajectory long_reference = sampled(0, 10 * kSecond, 50 * kMs);
  const Trajectory broken = at_times({0, 1000 * kMs, 2000 * kMs, 6000 * kMs, 7000 * kMs, 8000 * kMs});
  CHECK(associate_interpolated(broken, long_reference, 100 * kMs, kSecond).covered == Approx(0.4));
}

TEST_CASE("evo's rule: the nearest within the limit, from the shorter trajectory, with re-use") {  // eq. EVAL-2
  const Trajectory reference = at_times({0, 100 * kMs, 200 * kMs, 300 * kMs, 400 * kMs});
  const Trajectory estimate = at_times({9 * kMs, 89 * kMs, 210 * kMs, 311 * kMs});
  const Association a = associate_nearest(estimate, reference, 10 * kMs, kSecond);
  CHECK(times_of(a.pairs) == std::vector<TimeNs>{9 * kMs, 210 * kMs});
  CHECK(a.pairs[1].reference.p.x() == Approx(0.2));  // not interpolated
  CHECK(a.estimate_poses == 4);

  // The reference is shorter: each of its poses looks for one of the estimate, and both take the same.
  const Trajectory sparse = at_times({95 * kMs, 105 * kMs});
  const Trajectory dense = at_times({50 * kMs, 100 * kMs, 150 * kMs});
  const Association reused = associate_nearest(dense, sparse, 10 * kMs, kSecond);
  CHECK(times_of(reused.pairs) == std::vector<TimeNs>{100 * kMs, 100 * kMs});
  CHECK(reused.pairs[0].reference.p.x() == Approx(0.095));
  CHECK(reused.pairs[1].reference.p.x() == Approx(0.105));
}

TEST_CASE("the grid lies on multiples of the period, whatever the estimate's stamps") {  // eq. EVAL-3
  const Trajectory reference = sampled(-kSecond, 3 * kSecond, 5 * kMs);
  const Trajectory estimate = sampled(-233 * kMs, 1 * kSecond, 33 * kMs);
  const auto pairs = associate_on_grid(estimate, reference, 100 * kMs, 100 * kMs, kSecond);
  REQUIRE(pairs.size() == 12);
  CHECK(pairs.front().t == -200 * kMs);
  CHECK(pairs.back().t == 900 * kMs);
  CHECK(associate_on_grid(estimate, sampled(2 * kSecond, 3 * kSecond, 5 * kMs), 100 * kMs, 100 * kMs, kSecond).empty());
}

TEST_CASE("the grid passes over years without a pose, and none of its moments is lost behind them") {
  constexpr TimeNs kYears = 4'000'000'000 * kSecond;
  const Trajectory sparse = at_times({0, 150 * kMs, kYears, kYears + 130 * kMs, kYears + 250 * kMs});
  const std::vector<TimeNs> expected = {0, 100 * kMs, kYears, kYears + 100 * kMs, kYears + 200 * kMs};
  CHECK(times_of(associate_on_grid(sparse, sparse, 100 * kMs, 200 * kMs, kSecond)) == expected);
  // A gap of the reference alone, and one that ends between two moments.
  const Trajectory dense = sampled(0, 3 * kSecond, 10 * kMs), holed = at_times({0, 100 * kMs, 1950 * kMs, 2110 * kMs});
  CHECK(times_of(associate_on_grid(dense, holed, 100 * kMs, 200 * kMs, kSecond)) ==
        std::vector<TimeNs>{0, 100 * kMs, 2000 * kMs, 2100 * kMs});
}

TEST_CASE("no time in common: both ranges and the offset are named") {
  const Trajectory reference = sampled(1'600'000'000 * kSecond, 1'600'000'020 * kSecond, 100 * kMs);
  const Trajectory estimate = sampled(0, 20 * kSecond, 100 * kMs);
  CHECK_THROWS_AS(associate_interpolated(estimate, reference, 100 * kMs, kSecond), DataError);
  CHECK_THROWS_WITH(
      associate_interpolated(estimate, reference, 100 * kMs, kSecond),
      "estimate and reference have no time in common: the estimate is from 0.000 s to 20.000 s (201 "
      "poses), the reference from 1600000000.000 s to 1600000020.000 s (201 poses); the estimate begins "
      "-1600000000.000 s from the reference: is one of them in another clock (shift its stamps by this constant, "
      "`time_offset` of the reference) or of another recording?");
}

TEST_CASE("no time in common: a wrong unit of the stamps is named") {
  const Trajectory reference = sampled(100 * kSecond, 120 * kSecond, 100 * kMs);
  const Trajectory estimate = at_times({100'000 * kSecond, 110'000 * kSecond, 120'000 * kSecond});
  CHECK_THROWS_WITH(
      associate_interpolated(estimate, reference, 100 * kMs, kSecond),
      Catch::EndsWith("the estimate lasts 1e+03 times longer: are its stamps in ms (set its `time_unit`)?"));
  CHECK_THROWS_WITH(
      associate_interpolated(reference, estimate, 100 * kMs, kSecond),
      Catch::EndsWith("the reference lasts 1e+03 times longer: are its stamps in ms (set its `time_unit`)?"));
}

TEST_CASE("a reference too sparse, or nothing at all, is refused") {
  const Trajectory reference = sampled(0, 20 * kSecond, kSecond);
  const Trajectory estimate = sampled(50 * kMs, 10 * kSecond, 100 * kMs);
  CHECK_THROWS_WITH(associate_interpolated(estimate, reference, 100 * kMs, kSecond),
                    Catch::StartsWith("no estimated pose has a reference between two samples at most 0.1 s apart"));
  CHECK_THROWS_WITH(associate_nearest(estimate, reference, 10 * kMs, kSecond),
                    Catch::StartsWith("no estimated pose has a reference within 0.01 s"));
  CHECK_THROWS_AS(associate_interpolated({}, reference, 100 * kMs, kSecond), DataError);
  CHECK_THROWS_AS(associate_nearest(estimate, {}, 100 * kMs, kSecond), DataError);
}
