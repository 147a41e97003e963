/// What every window strategy owes the pipeline, on random streams with gaps, jitter and random overlaps.

#include <catch2/catch.hpp>
#include <random>

#include "plugins/build_environment.hpp"
#include "plugins/windows/configured_window.hpp"
#include "plugins/windows/fake_stream.hpp"
#include "temporary_folder.hpp"

namespace aslio {
namespace {

using test::kMs;

constexpr TimeNs kStart = 1'700'000'000 * kSecond;

TimeNs uniform(std::mt19937_64& random, TimeNs low, TimeNs high) {
  return low + static_cast<TimeNs>(random() % static_cast<std::uint64_t>(high - low + 1));
}

/// A schedule of two of the three seconds, with histories of up to 0.2 s.
std::string random_schedule() {
  std::mt19937_64 random(5);
  std::string text = "t_ns,window_begin_ns,gyro_rms_rad_s\n";
  for (TimeNs t = kStart + 30 * kMs; t < kStart + 2 * kSecond; t += uniform(random, kMs, 120 * kMs)) {
    text += std::to_string(t) + ',' + std::to_string(t - uniform(random, 0, 200 * kMs)) + ',' +
            std::to_string(uniform(random, 0, 400)) + "e-2\n";
  }
  return text;
}

/// Every registered window with its defaults and what it cannot do without, and variants. New types join by themselves.
class Candidates {
 public:
  Candidates() {
    const std::string file = ", file: " + folder_.write("updates.csv", random_schedule()).string();
    for (const std::string& window : catalog_.all()) {
      all_.push_back(window == "{type: replay}" ? "{type: replay" + file + "}" : window);
    }
    if (test::one_under_test(WindowStrategy::family)) return;
    all_.insert(all_.end(), {"{type: sod_adaptive, warmup: 0.3, seg_step: 0.005, weak_segments: 2}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.04, imu_samples: 3}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.03, imu_samples: 4, lookahead: true}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.04, min_points: 100}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.03, n_min: 4, min_points: 100}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.05, recover: ramp, lookahead: true}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.04, lookahead: true, min_points: 0}",
                             "{type: sod_adaptive, warmup: 0.3, seg_step: 0.04, min_points: 0, echo: false}",
                             "{type: fixed, period: 0.02, frame_length: 0.1}",
                             "{type: fixed, cut: sweep, frame_length: 0.3}",
                             "{type: overlapping, length: 0.07, step: 0.013}",
                             "{type: overlapping, length: 0.05, step: 0.05}",
                             "{type: motion_rate, min_points: 0, hold: 0}",
                             "{type: motion_rate, slow_period: 0.03, hold: 0.05}",
                             "{type: motion_rate, frame_length: 0.2, fast_period: 0.008, threshold_deg: 20}",
                             "{type: imu_rate, emit: cuts}",
                             "{type: imu_rate, emit: cuts, n_max: 32, rate_unit_deg: 4}",
                             "{type: imu_rate, frame_length: 0.05, n_max: 20, acc_unit: 0.5}",
                             "{type: replay, shift: 0.7" + file + "}",
                             "{type: replay, order: steady" + file + "}",
                             "{type: replay, order: turn_rate" + file + "}",
                             "{type: replay, order: shuffled, seed: 3" + file + "}",
                             "{type: replay, shift: -5, order: shuffled, period: 0.03" + file + "}"});
  }

  const std::vector<std::string>& all() const { return all_; }
  std::unique_ptr<WindowStrategy> make(const std::string& candidate) {
    return catalog_.read(candidate).make(environment_.context());
  }

 private:
  test::TemporaryFolder folder_;
  test::WindowCatalog catalog_;
  test::BuildEnvironment environment_;
  std::vector<std::string> all_;
};

/// Firings at random intervals with occasional gaps of up to 0.7 s; IMU with jitter, gaps and motions of random
/// strength, sometimes ending early.
test::FakeStream random_stream(std::mt19937_64& random) {
  std::vector<TimedPoint> points;
  const TimeNs step = uniform(random, kMs / 10, 2 * kMs);
  TimeNs t = kStart;
  const TimeNs end = t + 3 * kSecond;
  while (t < end) {
    t += random() % 400 == 0 ? uniform(random, 20 * kMs, 700 * kMs) : uniform(random, 1, 2 * step);
    const TimeNs firing = uniform(random, 1, 6);
    for (TimeNs i = 0; i < firing; ++i) {
      TimedPoint p;
      p.x = random() % 10 == 0 ? 0.1f : 5.0f;
      p.t = t;
      p.sweep_id = static_cast<std::uint32_t>((t - kStart) / (97 * kMs));
      points.push_back(p);
    }
  }
  std::vector<ImuSample> imu;
  const TimeNs imu_end = random() % 4 == 0 ? kStart + 2 * kSecond : end + 50 * kMs;
  double strength = 0;
  for (t = kStart - 20 * kMs; t < imu_end; t += uniform(random, 4 * kMs, 6 * kMs)) {
    if (random() % 30 == 0) strength = 0.1 * static_cast<double>(random() % 11);
    const double shake = strength * static_cast<double>(random() % 1001) / 1000.0;
    imu.push_back({.t = t, .gyro = {0, 0, 5.0 * shake}, .acc = {10.0 * shake, 0, kStandardGravity}});
    if (random() % 300 == 0) t += uniform(random, 20 * kMs, 300 * kMs);
  }
  return {std::move(points), std::move(imu)};
}

/// An overlap that depends on nothing but the time.
double overlap_at(TimeNs t) {
  std::mt19937_64 random(static_cast<std::uint64_t>(t));
  random.discard(3);
  const double u = static_cast<double>(random() % 1001) / 1000.0;
  return u < 0.5 ? 1.0 - 0.2 * u : 2.0 * (1.0 - u);
}

/// Pushes the stream in packets of up to `largest` points and IMU samples, in random interleaving.
std::vector<WindowPlan> drive(WindowStrategy& strategy, test::FakeStream stream, std::uint64_t seed, TimeNs largest) {
  std::mt19937_64 random(seed);
  test::FakeProbe probe([](TimeNs t) { return overlap_at(t / (10 * kMs)); });
  test::WindowLoop loop(strategy, probe, stream.all_points().front().t - 1,
                        [](const WindowPlan& plan) -> std::optional<double> {
                          return plan.end % 11 == 0 ? std::nullopt : std::optional(overlap_at(plan.end));
                        });
  while (largest > 0 && (!stream.points_complete() || !stream.imu_complete())) {
    stream.arrive_points(static_cast<std::size_t>(uniform(random, 0, largest)));
    stream.arrive_imu(static_cast<std::size_t>(uniform(random, 0, 1 + largest / 20)));
    const std::size_t known = loop.plans.size();
    loop.run(stream);
    for (std::size_t i = known; i < loop.plans.size(); ++i) {
      REQUIRE(loop.plans[i].end <= stream.points_until());
      REQUIRE(loop.plans[i].end <= stream.imu_until());
    }
  }
  stream.finish();
  loop.run(stream);
  REQUIRE(loop.run(stream) == 0);
  return loop.plans;
}

void check_plans(const std::vector<WindowPlan>& plans, const std::vector<TimedPoint>& points, TimeNs reach) {
  TimeNs begin = points.front().t - 1;
  std::size_t covered = 0;
  for (const WindowPlan& plan : plans) {
    REQUIRE(plan.fresh_begin == begin);
    REQUIRE(plan.end > plan.fresh_begin);
    REQUIRE(plan.history_begin <= plan.fresh_begin);
    REQUIRE(plan.fresh_begin - plan.history_begin <= reach);
    REQUIRE(plan.cut_count <= WindowPlan::kMaxCuts);
    for (std::uint32_t c = 0; c < plan.cut_count; ++c) {
      REQUIRE(plan.cuts[c] > (c == 0 ? plan.fresh_begin : plan.cuts[c - 1]));
    }
    if (plan.cut_count > 0) REQUIRE(plan.cuts[plan.cut_count - 1] == plan.end);
    const std::size_t before = covered;
    while (covered < points.size() && points[covered].t <= plan.end) ++covered;
    REQUIRE(covered > before);  // no window without points, so never more windows than firings
    begin = plan.end;
  }
  REQUIRE(covered == points.size());
}

bool same(const WindowPlan& a, const WindowPlan& b) {
  return a.history_begin == b.history_begin && a.fresh_begin == b.fresh_begin && a.end == b.end && a.cuts == b.cuts &&
         a.cut_count == b.cut_count && a.seg_time == b.seg_time && a.shift_time == b.shift_time && a.echo == b.echo &&
         a.extended == b.extended && a.partial == b.partial;
}

}  // namespace

TEST_CASE("every strategy tiles any stream, each point once, however the data was packed") {  // eq. WIN-3
  Candidates candidates;
  for (const std::string& candidate : candidates.all()) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      CAPTURE(candidate, seed);
      std::mt19937_64 random(seed);
      const test::FakeStream stream = random_stream(random);
      const auto strategy = candidates.make(candidate);
      REQUIRE(strategy);
      const auto whole = drive(*strategy, stream, seed, 0);
      check_plans(whole, stream.all_points(), strategy->reach());
      for (const WindowPlan& plan : whole) REQUIRE((plan.cut_count == 0 || strategy->gives_cuts()));
      for (const TimeNs largest : {7, 96, 5000}) {
        CAPTURE(largest);
        const auto packed = drive(*candidates.make(candidate), stream, seed + 100, largest);
        REQUIRE(packed.size() == whole.size());
        for (std::size_t i = 0; i < whole.size(); ++i) REQUIRE(same(packed[i], whole[i]));
      }
    }
  }
}

TEST_CASE("every strategy: an empty stream has no windows") {
  Candidates candidates;
  for (const std::string& candidate : candidates.all()) {
    CAPTURE(candidate);
    test::FakeStream stream({}, test::imu_samples(kStart, kStart + kSecond));
    test::FakeProbe probe = test::blind_probe();
    const auto strategy = candidates.make(candidate);
    test::WindowLoop loop(*strategy, probe, kStart, [](const WindowPlan&) { return 1.0; });
    stream.arrive_until(kStart + 500 * kMs);
    CHECK(loop.run(stream, 10) == 0);
    stream.finish();
    CHECK(loop.run(stream, 10) == 0);
  }
}

}  // namespace aslio
