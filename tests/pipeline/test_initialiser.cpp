// Where the first state comes from: verdicts, levelling, which samples count, impossible gravity.
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/pipeline/initialiser.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::pipeline;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;
const Vec3 kUp(0, 0, kStandardGravity);

/// A stream with one point at `first_point` and IMU samples that tests add.
struct Start {
  explicit Start(double first_point = 0) {
    LidarPacket packet;
    packet.stamp = kEpoch;
    TimedPoint point;
    point.x = 3;
    point.t = kEpoch + to_ns(first_point);
    packet.points.push_back(point);
    stream.push(std::move(packet));
  }
  /// Samples every `step` seconds in [begin, end].
  Start& imu(double begin, double end, double step, const Vec3& acc, const Vec3& gyro = Vec3::Zero()) {
    for (int k = 0; begin + k * step <= end + 1e-9; ++k)
      stream.push(ImuSample{kEpoch + to_ns(begin + k * step), gyro, acc});
    return *this;
  }
  std::optional<Initialisation> run(const InitialisationParams& params = {}) const {
    return initialise(stream, params, SensorModel{});
  }
  stream::MeasurementStream stream;
};

}  // namespace

TEST_CASE("initialisation without IMU: at the first point, whatever the IMU says") {
  Start start(0.05);
  REQUIRE_FALSE(initialise_without_imu(stream::MeasurementStream{}));
  start.stream.leave_imu_out();
  start.imu(0, 0.2, 0.005, kUp);
  CHECK(start.stream.counters().imu == 0);
  CHECK(start.stream.imu_until() == kTimeMax);
  const auto found = initialise_without_imu(start.stream);
  REQUIRE(found);
  CHECK(found->initial.state.t == kEpoch + to_ns(0.05) - 1);
  CHECK(found->initial.state.R == Mat3::Identity());
  CHECK(found->initial.state.p == Vec3::Zero());
  CHECK_THAT(found->verdict, Contains("without IMU"));
}

TEST_CASE("initialisation: an order seed puts off the first window by less than a sweep, and 0 does not") {
  CHECK(start_offset(0) == 0);
  std::vector<TimeNs> offsets;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) offsets.push_back(start_offset(seed));
  std::sort(offsets.begin(), offsets.end());
  CHECK(offsets.front() > 0);
  CHECK(offsets.back() < to_ns(0.1));
  for (std::size_t i = 1; i < offsets.size(); ++i) CHECK(offsets[i] - offsets[i - 1] < to_ns(0.1) / 8);

  Start start;
  start.imu(0, 0.3, 0.005, kUp);
  const auto later = initialise(start.stream, {}, SensorModel{}, to_ns(0.05));
  REQUIRE(later);
  CHECK(later->initial.state.t == kEpoch + to_ns(0.15));
  CHECK_THAT(later->verdict, Contains("over 21 samples"));
  CHECK(initialise_without_imu(start.stream, to_ns(0.05))->initial.state.t == kEpoch + to_ns(0.05) - 1);
}

TEST_CASE("initialisation: at rest the mean rate is the gyro bias") {  // eq. INI-2
  const Vec3 bias(0.004, -0.006, 0.002);
  const auto found = Start().imu(0, 0.2, 0.005, kUp, bias).run();
  REQUIRE(found);
  CHECK(found->initial.mode == InitialMode::static_start);
  CHECK((found->initial.state.b_w - bias).norm() < 1e-12);
  CHECK(found->initial.state.t == kEpoch + to_ns(0.1));
  CHECK(found->initial.state.v == Vec3::Zero());
  CHECK(found->initial.sigma_gyro_bias < 2e-3);
  CHECK_THAT(found->verdict, Contains("static start") && Contains("over 21 samples"));
}

TEST_CASE("initialisation: an accelerometer that reads too much is scaled to gravity where asked") {  // eq. INI-7
  const auto found = Start().imu(0, 0.2, 0.005, 1.02 * kUp).run();
  REQUIRE(found);
  CHECK(found->mean_force == Approx(1.02 * kStandardGravity));
  const simulator::AnalyticWorld world({.seed = 3});
  const auto source = world.source();
  const Recording recording = record(*source, world.begin_time() + 2 * kSecond);
  Recording too_much = recording;
  for (Measurement& m : too_much) {
    if (auto* sample = std::get_if<ImuSample>(&m)) sample->acc *= 1.02;
  }
  const auto difference = [&](const std::string& scale) {
    const auto config = shipped("fast_lio2", {"initialisation.scale_specific_force=" + scale});
    Run right(config, world.sensor()), wrong(config, world.sensor());
    right.play(recording);
    wrong.play(too_much);
    REQUIRE(right.updates.size() == wrong.updates.size());
    REQUIRE(right.updates.size() > 10);
    return (right.updates.back().state.b_a - wrong.updates.back().state.b_a).norm();
  };
  CHECK(difference("true") < 1e-6);
  CHECK(difference("false") > 1e-3);
}

TEST_CASE("initialisation: auto decides by the variation of the force and by the mean rate") {
  const auto verdict = [](double swing, double rate) {
    Start start;
    for (int k = 0; k <= 40; ++k) {
      start.stream.push(
          ImuSample{kEpoch + k * 5'000'000, Vec3(0, 0, rate), kUp + Vec3(k % 2 == 0 ? swing : -swing, 0, 0)});
    }
    return start.run()->initial.mode;
  };
  CHECK(verdict(0.0, 0.0) == InitialMode::static_start);
  CHECK(verdict(0.29, 0.049) == InitialMode::static_start);
  CHECK(verdict(0.31, 0.0) == InitialMode::dynamic_start);
  CHECK(verdict(0.0, 0.051) == InitialMode::dynamic_start);
}

TEST_CASE("initialisation: a dynamic start assumes neither rest nor a bias") {  // eq. INI-2
  Start start;
  start.imu(0, 0.2, 0.005, kUp, Vec3(0, 0, 1));
  const auto found = start.run();
  REQUIRE(found);
  CHECK(found->initial.mode == InitialMode::dynamic_start);
  CHECK(found->initial.state.b_w == Vec3::Zero());
  CHECK(found->initial.sigma_velocity >= 2.0);
  CHECK(found->initial.sigma_tilt == Approx(10 * 3.14159265358979 / 180));
  CHECK_THAT(found->verdict, Contains("dynamic start"));
  // What the configuration says outranks the data.
  CHECK(start.run({.mode = InitialisationMode::static_start})->initial.mode == InitialMode::static_start);
  CHECK(Start().imu(0, 0.2, 0.005, kUp).run({.mode = InitialisationMode::dynamic_start})->initial.mode ==
        InitialMode::dynamic_start);
}

TEST_CASE("initialisation: acceleration that cannot be gravity is refused, g with its factor") {
  CHECK_THROWS_AS(Start().imu(0, 0.2, 0.005, Vec3(0, 0, 1)).run(), DataError);
  CHECK_THROWS_WITH(Start().imu(0, 0.2, 0.005, Vec3(0, 0.6, 0.8)).run(),
                    Contains("1.000 m/s^2") && Contains("acc_unit: g") && Contains("9.80665"));
  CHECK_THROWS_WITH(Start().imu(0, 0.2, 0.005, Vec3(0, 0, 96)).run(),
                    Contains("96.000 m/s^2") && Contains("9.80665") && !Contains("acc_unit: g"));
  // One that starts up may read zeros for a while.
  CHECK_THROWS_AS(Start().imu(0, 2.2, 0.005, Vec3(0, 0, 0)).run(), DataError);
  CHECK_FALSE(Start().imu(0, 1.0, 0.005, Vec3(0, 0, 0)).run());
  CHECK(Start().imu(0, 1.0, 0.005, Vec3(0, 0, 0)).imu(1.0, 1.3, 0.005, kUp).run());
  CHECK_NOTHROW(Start().imu(0, 0.2, 0.005, Vec3(0, 0, 9.0)).run());
}

TEST_CASE("initialisation: in motion the mean force may be that of a step, but not gravity in another unit") {
  const Vec3 turning(0, 0, 0.2);
  for (const double force : {6.1, 13.6}) {
    CHECK_NOTHROW(Start().imu(0, 0.2, 0.005, Vec3(0, 0, force), turning).run());
    CHECK_THROWS_AS(Start().imu(0, 0.2, 0.005, Vec3(0, 0, force)).run(), DataError);
  }
  CHECK_THROWS_WITH(Start().imu(0, 0.2, 0.005, Vec3(0, 0, 0.62), turning).run(), Contains("acc_unit: g"));
  CHECK_THROWS_AS(Start().imu(0, 0.2, 0.005, Vec3(0, 0, 96), turning).run(), DataError);
}

TEST_CASE("initialisation: two samples of a 10 Hz IMU are enough, one is not") {
  CHECK_FALSE(Start().imu(0, 0.05, 0.1, kUp).run());
  const auto found = Start().imu(0, 0.1, 0.1, kUp).run();
  REQUIRE(found);
  CHECK_THAT(found->verdict, Contains("over 2 samples"));
  CHECK(found->initial.state.t == kEpoch + to_ns(0.1));
  CHECK_THAT(Start().imu(0, 0.21, 0.103, kUp).run()->verdict, Contains("over 2 samples"));
  // However they lie about the first point: the first sample alone may reach far enough.
  for (int shift = 0; shift < 206; ++shift) {
    CAPTURE(shift);
    const auto slow = Start(0.001 * shift).imu(0, 1, 0.206, kUp).run();
    REQUIRE(slow);
    CHECK_THAT(slow->verdict, Contains("over 2 samples"));
  }
}

TEST_CASE("initialisation: waits for a point and for IMU data that reach far enough") {
  stream::MeasurementStream no_points;
  for (int k = 0; k < 100; ++k) no_points.push(ImuSample{kEpoch + k * 5'000'000, Vec3::Zero(), kUp});
  CHECK_FALSE(initialise(no_points, {}, SensorModel{}));
  CHECK_FALSE(Start().run());
  CHECK_FALSE(Start().imu(0, 0.094, 0.005, kUp).run());
  CHECK(Start().imu(0, 0.1, 0.005, kUp).run());
  CHECK_FALSE(Start().imu(0, 0.1, 0.005, kUp).run({.time = 0.5}));
}

TEST_CASE("initialisation: IMU data before the first point is used, so that motion right after it does no harm") {
  const Vec3 bias(0.01, 0, 0);
  const auto found =
      Start(0.3).imu(0, 0.3, 0.005, kUp, bias).imu(0.305, 1, 0.005, kUp + Vec3(3, 0, 0), Vec3(0, 0, 4)).run();
  REQUIRE(found);
  CHECK(found->initial.mode == InitialMode::static_start);
  CHECK(found->initial.state.t == kEpoch + to_ns(0.3));
  CHECK((found->initial.state.b_w - bias).norm() < 1e-12);
  CHECK_THAT(found->verdict, Contains("over 21 samples"));  // the 0.1 s before the point, not all there is
}

TEST_CASE("initialisation: the levelled attitude takes the force to +z without yaw, in any position") {  // eq. INI-1
  std::vector<Vec3> forces = {kUp, -kUp, Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(1e-9, 0, -1), Vec3(0, 1e-14, -1)};
  for (int i = 0; i < 200; ++i) {
    const double z = -0.99 + i * 0.00995, a = 2.4 * i;
    forces.emplace_back(std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z);
  }
  for (const Vec3& force : forces) {
    const Vec3 acc = force.normalized() * kStandardGravity;
    CAPTURE(acc.transpose());
    const auto found = Start().imu(0, 0.2, 0.005, acc).run();
    REQUIRE(found);
    const Mat3& R = found->initial.state.R;
    CHECK((R.transpose() * R - Mat3::Identity()).norm() < 1e-12);
    CHECK(R.determinant() == Approx(1.0));
    CHECK((R * acc - kUp).norm() < 1e-8);
    CHECK(std::abs(R(1, 0)) < 1e-9);  // the x axis of the IMU looks along x of W ..
    CHECK(R(0, 0) > -1e-9);           // .. and not backwards
  }
}

TEST_CASE("initialisation: nothing is averaged over a gap of the IMU") {
  // One reading, four seconds of silence, then another attitude.
  const auto found = Start().imu(0, 0, 0.005, Vec3(9.8, 0, 0)).imu(4.0, 4.2, 0.005, kUp).run();
  REQUIRE(found);
  CHECK(found->initial.state.t == kEpoch + to_ns(4.1));
  CHECK(found->initial.state.R.isApprox(Mat3::Identity(), 1e-9));
  CHECK_THAT(found->verdict, Contains("over 21 samples"));
  CHECK_FALSE(Start().imu(0, 0, 0.005, kUp).imu(4.0, 4.05, 0.005, kUp).run());
}

TEST_CASE("initialisation: the first sweeps prove a rest only where they bind the velocity") {  // eq. INI-6
  SweepMotion motion;
  motion.gravity = Vec3(0, 0, -kStandardGravity);
  motion.shares = motion.believed = true;
  const auto start = [&](double sigma, bool moves) {
    Initialisation found;
    found.initial.mode = InitialMode::static_start;
    motion.sigma_velocity = sigma;
    motion.moves = moves;
    motion.velocity = moves ? Vec3(11, 0, 0) : Vec3(0.1, 0, 0);
    apply_sweep_motion(found, motion);
    return found;
  };
  CHECK(start(0.3, false).initial.mode == InitialMode::static_start);
  CHECK_THAT(start(0.3, false).verdict, Contains("at rest"));
  const Initialisation bare_road = start(3.7, false);
  CHECK(bare_road.initial.mode == InitialMode::dynamic_start);
  CHECK(bare_road.initial.sigma_velocity == 3.0);
  CHECK_THAT(bare_road.verdict, Contains("velocity not known"));
  CHECK_THAT(bare_road.doubt, Contains("the first sweeps do not bind it"));
  const Initialisation car = start(0.3, true);
  CHECK(car.initial.mode == InitialMode::moving_start);
  CHECK(car.initial.state.v.norm() == Approx(11));
  CHECK(car.doubt.empty());
  motion.believed = false;
  CHECK(start(0.3, true).initial.mode == InitialMode::dynamic_start);
  motion.believed = motion.ambiguous = true;
  CHECK(start(0.3, true).initial.mode == InitialMode::moving_start);
  CHECK_THAT(start(0.3, true).doubt,
             Contains("11.0 m/s is used, another one explains the first sweeps nearly as well"));
  CHECK(start(0.3, false).initial.mode == InitialMode::static_start);
  CHECK_FALSE(start(0.3, false).doubt.empty());
  motion.shares = motion.believed = motion.ambiguous = false;  // a narrow view in a sharp turn
  CHECK(start(0.3, false).initial.mode == InitialMode::dynamic_start);
  CHECK_THAT(start(0.3, false).doubt, Contains("the first sweeps share too little of the view"));
}

TEST_CASE("initialisation: a declared rest that the first sweeps contradict is kept, and doubted") {
  SweepMotion motion;
  motion.velocity = Vec3(11, 0, 0);
  motion.shares = motion.moves = motion.believed = true;
  Initialisation found;
  found.initial.mode = InitialMode::static_start;
  doubt_declared_rest(found, motion);
  CHECK(found.initial.mode == InitialMode::static_start);
  CHECK_THAT(found.doubt, Contains("a motion of 11.0 m/s"));
  Initialisation rest;
  motion.moves = false;
  doubt_declared_rest(rest, motion);
  CHECK(rest.doubt.empty());
}
