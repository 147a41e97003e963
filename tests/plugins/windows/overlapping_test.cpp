#include <catch2/catch.hpp>

#include "plugins/windows/configured_window.hpp"

namespace aslio {
namespace {

using test::kMs;

test::FakeStream dense_stream(TimeNs ms) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, ms * kMs, kMs);
  return {std::move(points), test::imu_samples(0, ms * kMs)};
}

}  // namespace

TEST_CASE("overlapping: each window is its step and what came before it, of one length in all") {
  const auto plans = test::plans_of("{type: overlapping, length: 0.2, step: 0.04}", dense_stream(400));
  REQUIRE(plans.size() == 10);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    CHECK(plans[i].fresh_begin == static_cast<TimeNs>(i) * 40 * kMs);
    CHECK(plans[i].end - plans[i].fresh_begin == 40 * kMs);
    CHECK(plans[i].end - plans[i].history_begin == 200 * kMs);
    CHECK(plans[i].shift_time == 0.04);
    CHECK_FALSE(plans[i].partial);
  }
}

TEST_CASE("overlapping: by default a sweep of 0.1 s in two halves") {  // eq. WIN-4
  const auto plans = test::plans_of("overlapping", dense_stream(400));
  REQUIRE(plans.size() == 8);
  CHECK(plans[3].history_begin == 100 * kMs);
  CHECK(plans[3].fresh_begin == 150 * kMs);
  CHECK(plans[3].end == 200 * kMs);
}

TEST_CASE("overlapping: with the step as long as the window there is no history") {
  const auto plans = test::plans_of("{type: overlapping, length: 0.1, step: 0.1}", dense_stream(500));
  REQUIRE(plans.size() == 5);
  for (const WindowPlan& plan : plans) {
    CHECK(plan.history_begin == plan.fresh_begin);
  }
}

TEST_CASE("overlapping: behind a gap a full step of points is taken, and none from before the window") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 200 * kMs, kMs);
  test::add_points(points, 1000 * kMs, 1200 * kMs, kMs);
  const auto plans = test::plans_of("overlapping", {std::move(points), test::imu_samples(0, 1200 * kMs)});
  REQUIRE(plans.size() == 8);
  CHECK(plans[4].fresh_begin == 200 * kMs);
  CHECK(plans[4].end == 1051 * kMs - 1);
  CHECK(plans[4].history_begin == plans[4].fresh_begin);  // the gap is longer than the window
  CHECK(plans[4].partial);
  CHECK_FALSE(plans[5].partial);
  CHECK(plans[5].end - plans[5].history_begin == 100 * kMs);
}

TEST_CASE("overlapping: a step longer than the window is refused") {
  const test::WindowCatalog catalog;
  CHECK(catalog.complaint("{type: overlapping, length: 0.1, step: 0.1}").empty());
  CHECK_THAT(
      catalog.complaint("{type: overlapping, length: 0.05, step: 0.1}"),
      Catch::Contains("window.yaml:2") && Catch::Contains("window.step") && Catch::Contains("must not exceed length"));
}

}  // namespace aslio
