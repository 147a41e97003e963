#include "windows/fixed.hpp"

#include <catch2/catch.hpp>

#include "plugins/build_environment.hpp"
#include "plugins/windows/fake_stream.hpp"

namespace aslio {
namespace {

using plugins::FixedWindow;
using test::kMs;

std::vector<WindowPlan> run(const FixedWindow::Params& params, test::FakeStream stream, TimeNs start = 0) {
  test::BuildEnvironment environment;
  FixedWindow strategy(params, environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(strategy, probe, start, [](const WindowPlan&) { return 0.1; });
  stream.finish();
  loop.run(stream);
  return loop.plans;
}

test::FakeStream stream_of(std::vector<TimedPoint> points) {
  const TimeNs end = points.back().t;
  return {std::move(points), test::imu_samples(0, end)};
}

}  // namespace

TEST_CASE("fixed: equal windows without history, and what is left at the end") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 450 * kMs, kMs);
  const auto plans = run({}, stream_of(std::move(points)));
  REQUIRE(plans.size() == 5);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    CHECK(plans[i].fresh_begin == static_cast<TimeNs>(i) * 100 * kMs);
    CHECK(plans[i].history_begin == plans[i].fresh_begin);
    CHECK_FALSE(plans[i].extended);
    CHECK(plans[i].partial == (i == 4));
  }
  CHECK(plans.back().end == 450 * kMs);
}

TEST_CASE("fixed: a frame longer than the period gives history") {
  FixedWindow::Params params;
  params.period = 0.05;
  params.frame_length = 0.2;
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 400 * kMs, kMs);
  const auto plans = run(params, stream_of(std::move(points)));
  REQUIRE(plans.size() == 8);
  for (const WindowPlan& plan : plans) CHECK(plan.end - plan.history_begin == 200 * kMs);
  test::BuildEnvironment environment;
  CHECK(FixedWindow(params, environment.context()).reach() >= 150 * kMs);
  CHECK(FixedWindow({}, environment.context()).reach() == 0);
}

TEST_CASE("fixed: a warm-up has an update every frame_length, until so long after the first insertion") {
  FixedWindow::Params params;
  params.period = 0.02;
  params.frame_length = 0.1;
  params.warmup = 0.3;
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 600 * kMs, kMs);
  const auto plans = run(params, stream_of(std::move(points)));
  REQUIRE(plans.size() == 14);  // to 400 ms in four windows, to 600 ms in ten
  for (std::size_t i = 0; i < plans.size(); ++i) {
    CHECK(plans[i].end - plans[i].fresh_begin == (i < 4 ? 100 : 20) * kMs);
    CHECK(plans[i].end - plans[i].history_begin == 100 * kMs);
  }
}

TEST_CASE("fixed: with sweeps the period is that of the sensor, whatever the key says") {
  test::BuildEnvironment environment;
  environment.sensor.sweep_period = 0.05;
  FixedWindow::Params params;
  params.cut = FixedWindow::Cut::sweep;
  params.frame_length = 0.08;
  FixedWindow strategy(params, environment.context());
  CHECK(strategy.reach() == 80 * kMs);  // longer than a sweep: there is history
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 500 * kMs, kMs);
  // Of sweeps of 50 ms the third and fourth are missing, and the seventh alone.
  for (TimedPoint& p : points) p.sweep_id = static_cast<std::uint32_t>((p.t - 1) / (50 * kMs));
  std::erase_if(points, [](const TimedPoint& p) { return p.sweep_id == 2 || p.sweep_id == 3 || p.sweep_id == 6; });
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(strategy, probe, 0, [](const WindowPlan&) { return 0.1; });
  test::FakeStream stream = stream_of(std::move(points));
  stream.finish();
  loop.run(stream);
  REQUIRE(loop.plans.size() == 7);
  for (std::size_t i = 0; i < loop.plans.size(); ++i) CHECK(loop.plans[i].partial == (i == 2));
}

TEST_CASE("fixed: few points do not lengthen a window") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 400 * kMs, 40 * kMs);
  const auto plans = run({}, stream_of(std::move(points)));
  REQUIRE(plans.size() == 4);
  for (const WindowPlan& plan : plans) CHECK(plan.end - plan.fresh_begin == 100 * kMs);
}

TEST_CASE("fixed: a gap is bridged by one window that holds a full period of points behind it") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 200 * kMs, kMs);
  test::add_points(points, 1000 * kMs, 1500 * kMs, kMs);
  const auto plans = run({}, stream_of(std::move(points)));
  REQUIRE(plans.size() >= 3);
  CHECK(plans[2].fresh_begin == 200 * kMs);
  CHECK(plans[2].end == 1101 * kMs - 1);
  CHECK(plans[2].partial);
  CHECK_FALSE(plans[3].partial);
  CHECK(plans.back().end == 1500 * kMs);
}

TEST_CASE("fixed: sweep windows end with the last point of each sweep, however long the sweep") {
  FixedWindow::Params params;
  params.cut = FixedWindow::Cut::sweep;
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 520 * kMs, kMs, 4, 104 * kMs);
  test::FakeStream stream = stream_of(std::move(points));

  test::BuildEnvironment environment;
  FixedWindow strategy(params, environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(strategy, probe, 0, [](const WindowPlan&) { return 1.0; });
  stream.arrive_until(104 * kMs);
  CHECK(loop.run(stream) == 0);  // the sweep may go on
  stream.arrive_points(8);
  CHECK(loop.run(stream) == 0);  // the IMU has not come this far
  stream.arrive_until(110 * kMs);
  CHECK(loop.run(stream) == 1);
  stream.finish();
  loop.run(stream);
  REQUIRE(loop.plans.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(loop.plans[i].end == static_cast<TimeNs>(i + 1) * 104 * kMs);
    CHECK_FALSE(loop.plans[i].partial);
  }
}

TEST_CASE("fixed: points that begin long after the IMU are reached in one window") {
  std::vector<TimedPoint> points;
  test::add_points(points, 3000 * kMs, 3500 * kMs, kMs);
  const auto plans = run({}, stream_of(std::move(points)));
  CHECK(plans.front().fresh_begin == 0);
  CHECK(plans.front().end == 3101 * kMs - 1);
  CHECK(plans.front().partial);
}

}  // namespace aslio
