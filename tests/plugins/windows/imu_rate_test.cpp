#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "aslio/core/lie.hpp"
#include "plugins/windows/configured_window.hpp"

namespace aslio {
namespace {

using test::kMs;

const Vec3 kUp(0, 0, kStandardGravity);

/// 10 points per ms over (0, 1 s]; IMU samples at 200 Hz as `motion` makes them of one at rest.
test::FakeStream moving_stream(const std::function<void(ImuSample&)>& motion) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 1000 * kMs, kMs, 10);
  std::vector<ImuSample> imu = test::imu_samples(0, 1000 * kMs);
  for (ImuSample& sample : imu) {
    sample.acc = kUp;
    motion(sample);
  }
  return {std::move(points), std::move(imu)};
}

/// Parts of the first frame.
double parts(const std::function<void(ImuSample&)>& motion, const std::string& window = "imu_rate") {
  const auto plans = test::plans_of(window, moving_stream(motion));
  REQUIRE_FALSE(plans.empty());
  return plans.front().seg_time;
}

}  // namespace

TEST_CASE("imu_rate: at rest a frame is one update") {
  const auto plans = test::plans_of("imu_rate", moving_stream([](ImuSample&) {}));
  REQUIRE(plans.size() == 10);
  for (const WindowPlan& plan : plans) {
    CHECK(plan.end - plan.fresh_begin == 100 * kMs);
    CHECK(plan.history_begin == plan.fresh_begin);
    CHECK(plan.seg_time == 1);
  }
}

TEST_CASE("imu_rate: one part more per 1.5 rad/s or 4 m/s^2, whichever is more, up to n_max") {  // eq. WIN-6
  struct Row {
    double rate, acceleration, parts;
  };
  const auto row = GENERATE(values<Row>({{1.49, 0, 1},
                                         {1.51, 0, 2},
                                         {2.99, 0, 2},
                                         {3.01, 0, 3},
                                         {4.6, 0, 4},
                                         {0, 3.99, 1},
                                         {0, 4.01, 2},
                                         {0, 12.1, 4},
                                         {1.6, 8.1, 3},
                                         {4.6, 8.1, 4},
                                         {100, 0, 8},
                                         {0, 1e9, 8}}));
  CAPTURE(row.rate, row.acceleration);
  // About the vertical, so that gravity stays where it is; a single sample of the frame will do.
  const auto motion = [&](ImuSample& sample) {
    if (sample.t != 70 * kMs) return;
    sample.gyro.z() = -row.rate;
    sample.acc.x() += row.acceleration;
  };
  CHECK(parts(motion) == row.parts);
}

TEST_CASE("imu_rate: the units and the most parts can be chosen") {
  const auto turn = [](ImuSample& sample) { sample.gyro.z() = 1.0; };  // 57.3 deg/s
  CHECK(parts(turn, "{type: imu_rate, rate_unit_deg: 10}") == 6);
  CHECK(parts(turn, "{type: imu_rate, rate_unit_deg: 10, n_max: 5}") == 5);
  CHECK(parts(turn, "{type: imu_rate, n_max: 1}") == 1);
  const auto push = [](ImuSample& sample) { sample.acc.y() += 1.0; };
  CHECK(parts(push, "{type: imu_rate, acc_unit: 0.3}") == 4);
}

TEST_CASE("imu_rate: gravity is taken off at the attitude of each sample") {
  // Half a turn about x within the frame, at 3.1 rad/s: the mean force would leave up to 2 g.
  const auto roll = [](ImuSample& sample) {
    sample.gyro.x() = 3.1;
    sample.acc = exp_so3(Vec3(3.1 * to_seconds(sample.t), 0, 0)).transpose() * kUp;
  };
  CHECK(parts(roll, "{type: imu_rate, frame_length: 1.0}") == 3);
}

TEST_CASE("imu_rate: gravity is taken off with the attitude and the biases of the last posterior") {
  test::BuildEnvironment environment;
  const auto strategy = test::WindowCatalog().read("imu_rate").make(environment.context());
  test::FakeProbe probe = test::blind_probe();
  const Vec3 gyro_bias(1.0, 1.0, 1.0), acc_bias(3.0, 0.0, 3.0);
  const Mat3 tilt = exp_so3(Vec3(1.2, 0.3, 0.0));
  test::FakeStream stream = moving_stream([&](ImuSample& sample) {
    sample.gyro += gyro_bias;
    sample.acc = tilt.transpose() * kUp + acc_bias;
  });
  stream.finish();
  Feedback feedback;
  feedback.state.R = tilt;
  feedback.state.b_w = gyro_bias;
  feedback.state.b_a = acc_bias;
  const auto plan = strategy->next(stream, feedback, probe);
  REQUIRE(plan);
  CHECK(plan->seg_time == 1);
}

TEST_CASE("imu_rate: a sample that is not finite counts for nothing, and hides nothing that comes after it") {
  const auto broken = [](ImuSample& sample) {
    sample.gyro.z() = sample.t == 20 * kMs ? 2.0 : 0.1;
    if (sample.t == 30 * kMs) sample.gyro.z() = std::nan("");
    if (sample.t == 40 * kMs) sample.acc.x() = std::nan("");
    if (sample.t == 45 * kMs) sample.gyro.x() = std::numeric_limits<double>::infinity();
    if (sample.t == 50 * kMs) sample.acc.z() = -std::numeric_limits<double>::infinity();
  };
  CHECK(parts(broken) == 2);
  CHECK(parts([&](ImuSample& sample) {
          broken(sample);
          if (sample.t == 80 * kMs) sample.acc.x() = 13.0;  // 13 m/s^2 across gravity: 3.25 units
        }) == 4);
  // The attitude is kept up over the time of a sample that is missing.
  const auto rolling = [](ImuSample& sample) {
    const double angle = 1.4 * to_seconds(sample.t);
    sample.gyro = Vec3(1.4, 0, 0);
    sample.acc = exp_so3(Vec3(-angle, 0, 0)) * kUp;
    if (sample.t > 20 * kMs && sample.t <= 50 * kMs) sample.gyro.setConstant(std::nan(""));
  };
  CHECK(parts(rolling, "{type: imu_rate, acc_unit: 0.2}") == 1);
}

TEST_CASE("imu_rate: the parts of a frame are equal, and each frame is cut by its own motion") {
  const auto plans = test::plans_of("imu_rate", moving_stream([](ImuSample& sample) {
                                      if (sample.t > 100 * kMs && sample.t <= 200 * kMs) sample.gyro.z() = 3.1;
                                    }));
  REQUIRE(plans.size() == 12);
  const std::vector<TimeNs> ends = {100'000'000, 133'333'333, 166'666'666, 200'000'000, 300'000'000};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    CHECK(plans[i].end == ends[i]);
    CHECK(plans[i].cut_count == 0);
    CHECK(plans[i].history_begin == ends[i] - 100 * kMs);
    CHECK(plans[i].seg_time == (i == 0 || i == 4 ? 1 : 3));
  }
  CHECK(plans[2].shift_time == Approx(0.1 / 3));
}

TEST_CASE("imu_rate: `cuts` names the parts of a frame in one window") {
  const auto plans = test::plans_of("{type: imu_rate, emit: cuts}", moving_stream([](ImuSample& sample) {
                                      if (sample.t > 100 * kMs && sample.t <= 200 * kMs) sample.gyro.z() = 3.1;
                                    }));
  REQUIRE(plans.size() == 10);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    CHECK(plans[i].end - plans[i].fresh_begin == 100 * kMs);
    CHECK(plans[i].cut_count == (i == 1 ? 3 : 0));
  }
  CHECK(plans[1].cuts[0] == 133'333'333);
  CHECK(plans[1].cuts[1] == 166'666'666);
  CHECK(plans[1].cuts[2] == 200'000'000);
}

TEST_CASE("imu_rate: behind a gap begins a new frame, and no part lies across it") {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 130 * kMs, kMs, 10);
  test::add_points(points, 600 * kMs, 1000 * kMs, kMs, 10);
  std::vector<ImuSample> imu = test::imu_samples(0, 1000 * kMs);
  for (ImuSample& sample : imu) {
    sample.acc = kUp;
    if (sample.t <= 500 * kMs) sample.gyro.z() = 4.6;
  }
  const test::FakeStream stream(std::move(points), std::move(imu));
  const auto updates = test::plans_of("imu_rate", stream);
  REQUIRE(updates.size() > 7);
  CHECK(updates[5].end == 150 * kMs);  // the second part of the second frame
  CHECK(updates[6].partial);
  CHECK(updates[6].end == 626 * kMs - 1);
  CHECK(updates[7].seg_time == 1);
  CHECK(updates[7].end - updates[7].fresh_begin == 100 * kMs);

  const auto frames = test::plans_of("{type: imu_rate, emit: cuts}", stream);
  REQUIRE(frames.size() > 2);
  CHECK(frames[0].cut_count == 4);
  CHECK(frames[1].end == 200 * kMs);
  CHECK(frames[2].partial);
  CHECK(frames[2].cut_count == 0);
}

TEST_CASE("imu_rate: waits for the IMU of the whole frame, then hands out its parts as points arrive") {
  test::BuildEnvironment environment;
  const auto strategy = test::WindowCatalog().read("imu_rate").make(environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(*strategy, probe, 0, [](const WindowPlan&) { return std::optional<double>(); });
  std::vector<TimedPoint> points;
  test::add_points(points, 0, 300 * kMs, kMs);
  std::vector<ImuSample> imu = test::imu_samples(0, 300 * kMs);
  for (ImuSample& sample : imu) sample.acc = kUp;
  imu[19].gyro.z() = 7.6;  // at 95 ms: 6 parts
  test::FakeStream stream(std::move(points), std::move(imu));
  stream.arrive_until(96 * kMs);
  CHECK(loop.run(stream) == 0);
  stream.arrive_imu(1);
  CHECK(loop.run(stream) == 5);
  CHECK(loop.plans.back().end == 83'333'333);
}

}  // namespace aslio
