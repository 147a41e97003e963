#include "windows/sod_adaptive.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "plugins/allocation_count.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/windows/configured_window.hpp"
#include "plugins/windows/fake_stream.hpp"

namespace aslio {
namespace {

using plugins::SodAdaptiveWindow;
using test::kMs;

SodAdaptiveWindow::Params without_warmup() {
  SodAdaptiveWindow::Params params;
  params.warmup = 0;
  return params;
}

/// `points_per_ms` points per ms over [0, ms], IMU at 200 Hz; nothing has arrived.
test::FakeStream dense_stream(TimeNs ms, int points_per_ms = 20) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, ms * kMs, kMs, points_per_ms);
  return {std::move(points), test::imu_samples(0, ms * kMs)};
}

std::vector<WindowPlan> run(const SodAdaptiveWindow::Params& params, test::FakeStream stream,
                            const test::WindowLoop::Overlap& overlap) {
  test::BuildEnvironment environment;
  SodAdaptiveWindow strategy(params, environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(strategy, probe, 0, overlap);
  stream.finish();
  loop.run(stream);
  return loop.plans;
}

test::WindowLoop::Overlap constant(std::optional<double> overlap) {
  return [overlap](const WindowPlan&) { return overlap; };
}

}  // namespace

TEST_CASE("the trace of the adaptive window") {  // eq. WIN-2
  // Overlap measured at the end of each window; length [ms] and n of the window, and the echo left when it was cut.
  struct Step {
    double overlap, shift_ms;
    int n;
    std::uint32_t echo;
  };
  const std::vector<Step> trace = {{.95, 100, 2, 1},  {.93, 100, 2, 1},  {.78, 100, 2, 1},  {.77, 50, 4, 4},
                                   {.55, 50, 4, 3},   {.52, 33.3, 6, 6}, {.60, 33.3, 6, 5}, {.66, 33.3, 6, 4},
                                   {.74, 33.3, 6, 3}, {.85, 33.3, 6, 2}, {.91, 33.3, 6, 1}, {.92, 100, 2, 1}};
  std::size_t k = 0;
  const auto plans = run(without_warmup(), dense_stream(700),
                         [&](const WindowPlan&) { return k < trace.size() ? trace[k++].overlap : 1.0; });
  REQUIRE(plans.size() >= trace.size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    CAPTURE(i);
    CHECK(1e-6 * static_cast<double>(plans[i].end - plans[i].fresh_begin) == Approx(trace[i].shift_ms).margin(0.04));
    CHECK(plans[i].seg_time == trace[i].n);
    CHECK(plans[i].echo == trace[i].echo);
    CHECK(plans[i].shift_time == Approx(to_seconds(200 * kMs / trace[i].n)).epsilon(1e-12));
    CHECK(plans[i].end - plans[i].history_begin == 100 * kMs);
  }
}

TEST_CASE("with n = 2 there is no history and with n = 9 it is 3.5 times the fresh interval") {
  const auto slow = run(without_warmup(), dense_stream(500), constant(0.95));
  for (const WindowPlan& plan : slow) CHECK(plan.history_begin == plan.fresh_begin);
  const auto fast = run(without_warmup(), dense_stream(500), constant(0.2));
  REQUIRE(fast.size() > 10);
  const WindowPlan& plan = fast[5];
  CHECK(static_cast<double>(plan.fresh_begin - plan.history_begin) / static_cast<double>(plan.end - plan.fresh_begin) ==
        Approx(3.5).epsilon(1e-6));
}

namespace {

/// Lengths [ms] of the windows that end in (begin, end] ms of an overlap of 0, which asks for n = 11: 18.2 ms.
std::vector<double> lengths(std::vector<ImuSample> imu, std::int64_t imu_samples, std::int64_t n_min, TimeNs begin,
                            TimeNs end) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, end * kMs, kMs, 20);
  SodAdaptiveWindow::Params params;
  params.warmup = 2.0;
  params.imu_samples = imu_samples;
  params.n_min = n_min;
  std::vector<double> found;
  for (const WindowPlan& plan : run(params, {std::move(points), std::move(imu)}, constant(0.0))) {
    if (plan.end <= begin * kMs || plan.partial) continue;
    found.push_back(1e-6 * static_cast<double>(plan.end - plan.fresh_begin));
  }
  return found;
}

}  // namespace

TEST_CASE("of late no more updates than IMU samples, unless that is asked for, but n_min in any case") {  // eq. WIN-8
  const auto shortest = [](TimeNs imu_period, std::int64_t samples, std::int64_t n_min = 2) {
    std::vector<ImuSample> imu;
    for (TimeNs t = 0; t <= 4000 * kMs; t += imu_period) imu.push_back({.t = t});
    // A gap of 1.5 s before the overlap counts says nothing about the rate.
    std::erase_if(imu, [](const ImuSample& sample) { return sample.t > 300 * kMs && sample.t < 1800 * kMs; });
    const std::vector<double> found = lengths(std::move(imu), samples, n_min, 0, 4000);
    return *std::min_element(found.begin(), found.end());
  };
  CHECK(shortest(5 * kMs, 1) == Approx(200.0 / 11).margin(0.01));
  CHECK(shortest(18 * kMs, 1) == Approx(200.0 / 11).margin(0.01));
  CHECK(shortest(30 * kMs, 1) == Approx(200.0 / 6).margin(0.01));
  CHECK(shortest(30 * kMs, 0) == Approx(200.0 / 11).margin(0.01));
  CHECK(shortest(10 * kMs, 3) == Approx(200.0 / 6).margin(0.01));
  CHECK(shortest(103 * kMs, 1) == 100.0);
  CHECK(shortest(103 * kMs, 1, 4) == 50.0);
}

TEST_CASE("an IMU that slows down is followed within seconds, however long it was fast") {  // eq. WIN-8
  std::vector<ImuSample> imu;
  for (TimeNs t = 0; t <= 40'000 * kMs; t += (t < 30'000 * kMs ? 5 : 50) * kMs) imu.push_back({.t = t});
  const std::vector<double> before = lengths(imu, 1, 2, 29'000, 30'000), after = lengths(imu, 1, 2, 36'000, 40'000);
  CHECK(*std::max_element(before.begin(), before.end()) == Approx(200.0 / 11).margin(0.01));
  CHECK(*std::min_element(after.begin(), after.end()) == Approx(50.0).margin(0.01));
}

TEST_CASE("the overlap is ignored until the warm-up after the first insertion is over") {
  SodAdaptiveWindow::Params params;
  params.warmup = 0.5;
  const auto plans = run(params, dense_stream(900), constant(0.0));
  // The first insertion is at 0.1 s, so the feedback of 0.6 s is the first that counts.
  for (const WindowPlan& plan : plans) {
    CAPTURE(plan.fresh_begin);
    CHECK(plan.seg_time == (plan.fresh_begin < 600 * kMs ? 2 : 11));
  }
  CHECK(plans.back().seg_time == 11);
}

TEST_CASE("an undefined overlap keeps the rate") {
  int k = 0;
  const auto plans = run(without_warmup(), dense_stream(900),
                         [&](const WindowPlan&) { return k++ == 0 ? std::optional(0.5) : std::nullopt; });
  REQUIRE(plans.size() > 20);
  for (std::size_t i = 1; i + 1 < plans.size(); ++i) CHECK(plans[i].seg_time == 6);
}

TEST_CASE(
    "weak_segments shortens the window after a weak update at full overlap, and 2 leaves the overlap alone to decide") {
  for (const std::int64_t weak_segments : {2, 4}) {
    // A view that is open may be hidden by a last step that was long.
    for (const UpdateStatus status : {UpdateStatus::ok, UpdateStatus::not_converged, UpdateStatus::few_matches}) {
      SodAdaptiveWindow::Params params = without_warmup();
      params.weak_segments = weak_segments;
      test::BuildEnvironment environment;
      SodAdaptiveWindow strategy(params, environment.context());
      test::FakeStream stream = dense_stream(500);
      stream.finish();
      test::FakeProbe probe = test::blind_probe();
      Feedback feedback;
      feedback.first_insertion = 0;
      const auto first = strategy.next(stream, feedback, probe);
      REQUIRE(first);
      feedback.t = first->end;
      feedback.status = status;
      feedback.unobservable = status == UpdateStatus::not_converged;
      feedback.overlap.value = 1.0;
      const auto second = strategy.next(stream, feedback, probe);
      REQUIRE(second);
      CHECK(second->seg_time == (status == UpdateStatus::ok ? 2 : static_cast<double>(weak_segments)));
    }
  }
}

TEST_CASE(
    "n_min keeps old points in the window at full overlap, and a weak update with fewer segments changes nothing") {
  SodAdaptiveWindow::Params params = without_warmup();
  params.n_min = 4;
  params.weak_segments = 3;
  const auto plans = run(params, dense_stream(500), constant(1.0));
  REQUIRE(plans.size() == 10);
  for (const WindowPlan& plan : plans) {
    CHECK(plan.seg_time == 4);
    CHECK(plan.end - plan.fresh_begin == 50 * kMs);
    CHECK(plan.fresh_begin - plan.history_begin == 50 * kMs);
  }
}

TEST_CASE("n_min above n_max, or with a shift below shift_min, is refused") {
  using Catch::Contains;
  const test::WindowCatalog catalog;
  CHECK_THAT(catalog.complaint("{type: sod_adaptive, n_min: 30, n_max: 25}"), Contains("n_min"));
  CHECK_THAT(catalog.complaint("{type: sod_adaptive, n_min: 4, shift_min: 0.06}"), Contains("shift_min"));
  for (const char* shortest : {"0", "1e-10", "-1e-9"}) {
    CHECK_THAT(catalog.complaint(std::string("{type: sod_adaptive, shift_min: ") + shortest + "}"),
               Contains("shift_min") && Contains("out of range"));
  }
  // 0.2 s hold it three times but for the last nanosecond.
  CHECK_THAT(catalog.complaint("{type: sod_adaptive, n_min: 3, shift_min: 0.0666666667}"), Contains("shift_min"));
}

TEST_CASE("the shortest shift limits n, so that n, shift and echo stay consistent") {
  SodAdaptiveWindow::Params params = without_warmup();
  params.shift_min = 0.02;
  const auto plans = run(params, dense_stream(600), constant(0.0));
  CHECK(plans[1].seg_time == 10);
  CHECK(plans[1].echo == 10);
  CHECK(plans[1].end - plans[1].fresh_begin == 20 * kMs);
  params.n_max = 4;
  CHECK(run(params, dense_stream(600), constant(0.0))[1].seg_time == 4);
}

TEST_CASE("too few points lengthen the shift to the point that makes them enough") {
  // 5 points per ms: n = 11 wants 18.18 ms with 90 points, 300 points take 60 ms.
  const auto plans = run(without_warmup(), dense_stream(500, 5), constant(0.0));
  REQUIRE(plans.size() > 3);
  CHECK_FALSE(plans[0].extended);
  for (std::size_t i = 1; i + 1 < plans.size(); ++i) {
    CHECK(plans[i].extended);
    CHECK(plans[i].end - plans[i].fresh_begin == 60 * kMs);
  }
}

TEST_CASE("the shift grows up to the frame length and no farther") {
  const auto plans = run(without_warmup(), dense_stream(500, 1), constant(0.0));
  REQUIRE(plans.size() == 5);
  for (const WindowPlan& plan : plans) CHECK(plan.end - plan.fresh_begin == 100 * kMs);
  CHECK(plans[1].extended);
  CHECK_FALSE(plans[1].partial);
}

TEST_CASE("points out of the sensor's range do not count as enough points") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 500 * kMs, kMs, 20);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 4 != 0) points[i].x = i % 4 == 1 ? 0.1f : 2000.0f;
  }
  const auto plans = run(without_warmup(), {std::move(points), test::imu_samples(0, 500 * kMs)}, constant(0.0));
  CHECK(plans[1].extended);
  CHECK(plans[1].end - plans[1].fresh_begin == 60 * kMs);
}

TEST_CASE("a window waits for the IMU as long as the source has not ended") {
  test::BuildEnvironment environment;
  SodAdaptiveWindow strategy(without_warmup(), environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(strategy, probe, 0, constant(0.95));
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 400 * kMs, kMs, 20);
  test::FakeStream stream(std::move(points), test::imu_samples(0, 150 * kMs));
  stream.arrive_until(400 * kMs);
  CHECK(loop.run(stream) == 1);
  stream.finish();
  CHECK(loop.run(stream) == 3);
  CHECK(loop.plans.back().end == 400 * kMs);
}

TEST_CASE("a gap becomes part of the window behind it, and the next overlap decides the rate") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 450 * kMs, kMs, 20);
  test::add_points(points, 2000 * kMs, 2600 * kMs, kMs, 20);
  const auto plans = run(without_warmup(), {std::move(points), test::imu_samples(0, 2600 * kMs)},
                         [](const WindowPlan& plan) { return plan.end < 1000 * kMs ? 0.0 : 0.95; });
  std::size_t over_gap = 0;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (plans[i].end - plans[i].fresh_begin <= 100 * kMs) continue;
    ++over_gap;
    CHECK(plans[i].partial);
    CHECK(plans[i].fresh_begin >= 450 * kMs);
    CHECK(plans[i].end == 2001 * kMs - 1 + 200 * kMs / 11);
    CHECK(plans[i].seg_time == 11);
    REQUIRE(i + 1 < plans.size());
    CHECK(plans[i + 1].seg_time == 2);  // although the echo of n = 11 had not run out
  }
  CHECK(over_gap == 1);
}

TEST_CASE("a gap of more than two frames ends the echo even where the window before it took the first part") {
  // The last points before the gap are few, so that a window of a full frame runs into it.
  const auto second_slow = [](TimeNs gap_end) {
    std::vector<TimedPoint> points;
    test::add_points(points, 0, 450 * kMs, kMs, 20);
    test::add_points(points, gap_end, gap_end + 600 * kMs, kMs, 20);
    const auto plans = run(without_warmup(), {std::move(points), test::imu_samples(0, gap_end + 600 * kMs)},
                           [](const WindowPlan& plan) { return plan.end <= 600 * kMs ? 0.0 : 0.95; });
    std::size_t i = 0;
    while (plans.at(i).end <= gap_end) ++i;
    CHECK(plans[i].seg_time == 11);
    CHECK(plans[i].end - plans[i].fresh_begin < 200 * kMs);
    return plans.at(i + 1).seg_time;
  };
  CHECK(second_slow(655 * kMs) == 2);
  CHECK(second_slow(645 * kMs) == 11);
}

TEST_CASE("while the IMU says nothing, and soon after, the rate does not rise") {  // eq. WIN-8
  for (const bool dead : {false, true}) {
    CAPTURE(dead);
    std::vector<TimedPoint> points;
    test::add_points(points, 0, 3000 * kMs, kMs, 20);
    std::vector<ImuSample> imu = test::imu_samples(0, 3000 * kMs);
    const auto in_gap = [](const ImuSample& s) { return s.t > 1000 * kMs && s.t < 1500 * kMs; };
    if (dead) {
      for (ImuSample& s : imu) s.faults = in_gap(s) ? imu_fault::gyro_dead : 0;
    } else {
      std::erase_if(imu, in_gap);
    }
    const auto plans =
        run(without_warmup(), {std::move(points), std::move(imu)}, [](const WindowPlan&) { return 0.0; });
    for (const WindowPlan& plan : plans) {
      CAPTURE(plan.end);
      if (plan.fresh_begin > 1100 * kMs && plan.end < 1950 * kMs) CHECK(plan.seg_time == 2);
      if (plan.end < 1000 * kMs && plan.fresh_begin > 200 * kMs) CHECK(plan.seg_time > 10);
      if (plan.fresh_begin > 2300 * kMs && plan.end < 2900 * kMs) CHECK(plan.seg_time > 10);
    }
    CHECK(plans.size() > 50);
  }
}

TEST_CASE("a gap in the IMU data of more than two frames ends the echo") {
  for (const TimeNs gap : {195 * kMs, 205 * kMs}) {
    std::vector<TimedPoint> points;
    test::add_points(points, 0, 1200 * kMs, kMs, 20);
    std::vector<ImuSample> imu = test::imu_samples(0, 400 * kMs);
    for (const ImuSample& sample : test::imu_samples(400 * kMs + gap, 1200 * kMs)) imu.push_back(sample);
    // Low once, within the gap: n = 11 from 500 ms to 700 ms unless the end of the gap, about 600 ms, ends it.
    SodAdaptiveWindow::Params params = without_warmup();
    params.imu_samples = 0;  // the overlap alone decides
    const auto plans = run(params, {std::move(points), std::move(imu)},
                           [](const WindowPlan& plan) { return plan.end == 500 * kMs ? 0.0 : 0.95; });
    std::size_t i = 0;
    while (plans.at(i).end < 400 * kMs + gap) ++i;
    CHECK(plans[i].seg_time == 11);
    CHECK(plans.at(i + 1).seg_time == (gap > 200 * kMs ? 2 : 11));
  }
}

TEST_CASE("the echo can be switched off: then n falls with the next overlap") {
  SodAdaptiveWindow::Params params = without_warmup();
  const auto dip = [](const WindowPlan& plan) { return plan.fresh_begin == 100 * kMs ? 0.25 : 0.95; };
  const auto n_after_dip = [&](std::size_t k) { return run(params, dense_stream(800), dip).at(1 + k).seg_time; };
  CHECK(n_after_dip(1) == 9);
  CHECK(n_after_dip(9) == 9);
  CHECK(n_after_dip(10) == 2);
  params.echo = false;
  CHECK(n_after_dip(1) == 9);
  CHECK(n_after_dip(2) == 2);
  CHECK(run(params, dense_stream(800), dip).at(2).echo == 1);
}

TEST_CASE("the stream ends with a partial window that holds the last point") {
  const auto plans = run(without_warmup(), dense_stream(333), constant(0.95));
  REQUIRE(plans.size() == 4);
  CHECK_FALSE(plans[2].partial);
  CHECK(plans[3].partial);
  CHECK(plans[3].end == 333 * kMs);
}

TEST_CASE("look-ahead cuts the pending window short when coming points are unknown to the map") {
  SodAdaptiveWindow::Params params = without_warmup();
  params.lookahead = true;
  test::BuildEnvironment environment;
  SodAdaptiveWindow strategy(params, environment.context());
  // From 230 ms on the view is new.
  test::FakeProbe probe([](TimeNs t) { return t >= 230 * kMs ? 0.5 : 1.0; });
  test::WindowLoop loop(strategy, probe, 0, constant(0.95));
  test::FakeStream stream = dense_stream(600);
  stream.arrive_until(225 * kMs);
  CHECK(loop.run(stream) == 2);
  stream.arrive_until(229 * kMs);
  CHECK(loop.run(stream) == 0);
  stream.finish();
  loop.run(stream);
  REQUIRE(loop.plans.size() > 4);
  CHECK(loop.plans[2].fresh_begin == 200 * kMs);
  CHECK(loop.plans[2].seg_time == 6);
  CHECK(loop.plans[2].end == 200 * kMs + 200 * kMs / 6);
  // Every slice is looked at once, none beyond the end of its window, and none before there is a map.
  for (std::size_t i = 1; i < probe.asked.size(); ++i) CHECK(probe.asked[i] > probe.asked[i - 1]);
  CHECK(probe.asked.front() == 110 * kMs);
}

TEST_CASE("look-ahead never cuts a window before the points it has looked at") {
  SodAdaptiveWindow::Params params = without_warmup();
  params.lookahead = true;
  test::BuildEnvironment environment;
  SodAdaptiveWindow strategy(params, environment.context());
  test::FakeProbe probe([](TimeNs t) { return t >= 280 * kMs ? 0.0 : 1.0; });
  test::WindowLoop loop(strategy, probe, 0, constant(0.95));
  test::FakeStream stream = dense_stream(600);
  stream.finish();
  loop.run(stream);
  CHECK(loop.plans[2].seg_time == 11);
  CHECK(loop.plans[2].end == 280 * kMs);
}

TEST_CASE("cutting windows does not allocate") {
  test::BuildEnvironment environment;
  SodAdaptiveWindow strategy(without_warmup(), environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::FakeStream stream = dense_stream(900);
  stream.finish();
  Feedback feedback;
  feedback.first_insertion = 0;
  feedback.overlap.value = 0.3;
  const std::size_t before = test::allocation_count();
  int windows = 0;
  while (const auto plan = strategy.next(stream, feedback, probe)) {
    feedback.t = plan->end;
    ++windows;
  }
  CHECK(test::allocation_count() == before);
  CHECK(windows > 30);
}

}  // namespace aslio
