#include <catch2/catch.hpp>

#include "plugins/windows/configured_window.hpp"

namespace aslio {
namespace {

using test::kMs;

/// 20 points per ms over [0, 1 s]; the gyro turns at `rate` rad/s about z in [begin, end], beside a bias.
test::FakeStream turning_stream(TimeNs begin, TimeNs end, double rate, const Vec3& bias = Vec3::Zero(),
                                int points_per_ms = 20) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 1000 * kMs, kMs, points_per_ms);
  std::vector<ImuSample> imu = test::imu_samples(0, 1000 * kMs);
  for (ImuSample& sample : imu) {
    sample.gyro = bias;
    if (sample.t >= begin && sample.t <= end) sample.gyro.z() += rate;
  }
  return {std::move(points), std::move(imu)};
}

std::vector<TimeNs> ends_in_ms(const std::vector<WindowPlan>& plans) {
  std::vector<TimeNs> ends;
  for (const WindowPlan& plan : plans) ends.push_back(plan.end / kMs);
  return ends;
}

}  // namespace

TEST_CASE("motion_rate: without a turn an update per frame, without history") {           // eq. WIN-5
  const auto plans = test::plans_of("motion_rate", turning_stream(0, 1000 * kMs, 1.04));  // 59.6 deg/s
  REQUIRE(plans.size() == 10);
  for (const WindowPlan& plan : plans) {
    CHECK(plan.end - plan.fresh_begin == 100 * kMs);
    CHECK(plan.history_begin == plan.fresh_begin);
  }
}

TEST_CASE("motion_rate: the pending window ends where a turn begins, and updates are fast until `hold` after it") {
  // The last sample of the turn is at 300 ms: begins up to 399 ms still see it within 100 ms.
  const auto plans =
      test::plans_of("{type: motion_rate, hold: 0.1}", turning_stream(230 * kMs, 300 * kMs, 1.06));  // 60.7 deg/s
  CHECK(ends_in_ms(plans) ==
        std::vector<TimeNs>{100, 200, 230, 250, 270, 290, 310, 330, 350, 370, 390, 410, 510, 610, 710, 810, 910, 1000});
  CHECK(plans[4].end - plans[4].history_begin == 100 * kMs);
  CHECK(plans[4].shift_time == Approx(0.02));
  CHECK(plans[2].shift_time == Approx(0.03));
}

TEST_CASE("motion_rate: a turn at once after the begin leaves the window its fast period") {
  const auto plans = test::plans_of("{type: motion_rate, hold: 0}", turning_stream(205 * kMs, 205 * kMs, -4.0));
  CHECK(ends_in_ms(plans) == std::vector<TimeNs>{100, 200, 220, 320, 420, 520, 620, 720, 820, 920, 1000});
}

TEST_CASE("motion_rate: the gyro's bias is no turn") {
  test::BuildEnvironment environment;
  const Vec3 bias(0.8, -0.8, 0.8);  // 79 deg/s
  const auto strategy = test::WindowCatalog().read("motion_rate").make(environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(*strategy, probe, 0, [](const WindowPlan&) { return std::optional<double>(); });
  loop.feedback().state.b_w = bias;
  test::FakeStream stream = turning_stream(0, 0, 0.0, bias);
  stream.finish();
  CHECK(loop.run(stream) == 10);
  CHECK(test::plans_of("motion_rate", std::move(stream)).size() == 50);
}

TEST_CASE("motion_rate: waits for the IMU of a whole frame unless a turn has been seen") {
  test::BuildEnvironment environment;
  const auto strategy = test::WindowCatalog().read("motion_rate").make(environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(*strategy, probe, 0, [](const WindowPlan&) { return std::optional<double>(); });
  test::FakeStream stream = turning_stream(140 * kMs, 150 * kMs, 3.0);
  stream.arrive_until(135 * kMs);
  CHECK(loop.run(stream) == 1);
  stream.arrive_until(145 * kMs);
  CHECK(loop.run(stream) == 1);
  CHECK(loop.plans.back().end == 140 * kMs);
}

TEST_CASE("motion_rate: with too few points the time between updates grows, up to a frame") {
  for (const auto& [per_ms, ms] : {std::pair{10, 30}, {1, 100}}) {
    const auto plans = test::plans_of("motion_rate", turning_stream(0, 1000 * kMs, 2.0, Vec3::Zero(), per_ms));
    REQUIRE(plans.size() > 3);
    CHECK(plans[2].end - plans[2].fresh_begin == ms * kMs);
    CHECK(plans[2].extended);
    CHECK(plans[2].end - plans[2].history_begin == 100 * kMs);
  }
}

TEST_CASE("motion_rate: slow_period is the time between updates without a turn, in windows of a frame") {
  const auto plans = test::plans_of("{type: motion_rate, slow_period: 0.05}", turning_stream(0, 1000 * kMs, 1.04));
  REQUIRE(plans.size() == 20);
  for (std::size_t i = 2; i < plans.size(); ++i) {
    CHECK(plans[i].end - plans[i].fresh_begin == 50 * kMs);
    CHECK(plans[i].end - plans[i].history_begin == 100 * kMs);
  }
}

TEST_CASE("motion_rate: periods that exceed the next longer one are refused") {
  CHECK_THAT(test::WindowCatalog().complaint("{type: motion_rate, slow_period: 0.2}"),
             Catch::Contains("slow_period") && Catch::Contains("frame_length"));
  CHECK_THAT(test::WindowCatalog().complaint("{type: motion_rate, slow_period: 0.05, fast_period: 0.06}"),
             Catch::Contains("fast_period") && Catch::Contains("slow_period"));
}

TEST_CASE("motion_rate: a fast period longer than the frame is refused") {
  CHECK_THAT(test::WindowCatalog().complaint("{type: motion_rate, fast_period: 0.2}"),
             Catch::Contains("window.fast_period") && Catch::Contains("must not exceed frame_length"));
}

}  // namespace aslio
