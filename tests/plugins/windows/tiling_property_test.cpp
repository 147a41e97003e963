/// What every window strategy owes the pipeline, on random streams with gaps, jitter and random overlaps.

#include <catch2/catch.hpp>
#include <random>

#include "aslio/plugin/registry.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/windows/fake_stream.hpp"
#include "register_all.hpp"
#include "windows/fixed.hpp"
#include "windows/sod_adaptive.hpp"

namespace aslio {
namespace {

using plugins::FixedWindow;
using plugins::SodAdaptiveWindow;
using test::kMs;

struct Candidate {
  std::string name;
  std::function<std::unique_ptr<WindowStrategy>()> make;
};

/// Every registered type with its defaults, and variants of those of this directory.
std::vector<Candidate> candidates(test::BuildEnvironment& environment, const plugin::Catalog& catalog) {
  std::vector<Candidate> all;
  for (const std::string& type : catalog.types(WindowStrategy::family)) {
    const plugin::Entry* entry = catalog.find(WindowStrategy::family, type);
    all.push_back({type, [entry, &environment] {
                     const auto params = entry->defaults();
                     return std::unique_ptr<WindowStrategy>(
                         dynamic_cast<WindowStrategy*>(entry->make(params.get(), environment.context()).release()));
                   }});
  }
  const auto sod = [&](std::string name, SodAdaptiveWindow::Params params) {
    params.warmup = 0.3;
    all.push_back({std::move(name), [params, &environment] {
                     return std::make_unique<SodAdaptiveWindow>(params, environment.context());
                   }});
  };
  sod("sod: paper rate", {.seg_step = 0.04, .min_points = 100});
  sod("sod: ramp, look-ahead", {.seg_step = 0.05, .recover = plugins::Recover::ramp, .lookahead = true});
  sod("sod: any number of points", {.seg_step = 0.04, .lookahead = true, .min_points = 0});
  const auto fixed = [&](std::string name, const FixedWindow::Params& params) {
    all.push_back({std::move(name),
                   [params, &environment] { return std::make_unique<FixedWindow>(params, environment.context()); }});
  };
  fixed("fixed: 20 ms with history", {.period = 0.02, .frame_length = 0.1});
  fixed("fixed: sweeps with history", {.cut = FixedWindow::Cut::sweep, .frame_length = 0.3});
  return all;
}

TimeNs uniform(std::mt19937_64& random, TimeNs low, TimeNs high) {
  return low + static_cast<TimeNs>(random() % static_cast<std::uint64_t>(high - low + 1));
}

/// Firings at random intervals with occasional gaps of up to 0.7 s; IMU with jitter and gaps, sometimes ending early.
test::FakeStream random_stream(std::mt19937_64& random) {
  std::vector<TimedPoint> points;
  const TimeNs step = uniform(random, kMs / 10, 2 * kMs);
  TimeNs t = 1'700'000'000 * kSecond;
  const TimeNs start = t;
  const TimeNs end = t + 3 * kSecond;
  while (t < end) {
    t += random() % 400 == 0 ? uniform(random, 20 * kMs, 700 * kMs) : uniform(random, 1, 2 * step);
    const TimeNs firing = uniform(random, 1, 6);
    for (TimeNs i = 0; i < firing; ++i) {
      TimedPoint p;
      p.x = random() % 10 == 0 ? 0.1f : 5.0f;
      p.t = t;
      p.sweep_id = static_cast<std::uint32_t>((t - start) / (97 * kMs));
      points.push_back(p);
    }
  }
  std::vector<ImuSample> imu;
  const TimeNs imu_end = random() % 4 == 0 ? start + 2 * kSecond : end + 50 * kMs;
  for (t = start - 20 * kMs; t < imu_end; t += uniform(random, 4 * kMs, 6 * kMs)) {
    imu.push_back({.t = t});
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

TEST_CASE("every strategy tiles any stream, each point once, however the data was packed") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  for (const Candidate& candidate : candidates(environment, catalog)) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      CAPTURE(candidate.name, seed);
      std::mt19937_64 random(seed);
      const test::FakeStream stream = random_stream(random);
      const auto strategy = candidate.make();
      REQUIRE(strategy);
      const auto whole = drive(*strategy, stream, seed, 0);
      check_plans(whole, stream.all_points(), strategy->reach());
      for (const TimeNs largest : {7, 96, 5000}) {
        CAPTURE(largest);
        const auto packed = drive(*candidate.make(), stream, seed + 100, largest);
        REQUIRE(packed.size() == whole.size());
        for (std::size_t i = 0; i < whole.size(); ++i) REQUIRE(same(packed[i], whole[i]));
      }
    }
  }
}

TEST_CASE("an empty stream has no windows") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  for (const Candidate& candidate : candidates(environment, catalog)) {
    CAPTURE(candidate.name);
    test::FakeStream stream({}, test::imu_samples(0, 1000 * kMs));
    test::FakeProbe probe = test::blind_probe();
    const auto strategy = candidate.make();
    test::WindowLoop loop(*strategy, probe, 0, [](const WindowPlan&) { return 1.0; });
    stream.arrive_until(500 * kMs);
    CHECK(loop.run(stream, 10) == 0);
    stream.finish();
    CHECK(loop.run(stream, 10) == 0);
  }
}

}  // namespace aslio
