// hard_voxel and soft_voxel beyond the contract: weights, metrics, floor, delay.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <initializer_list>
#include <random>

#include "aslio/core/errors.hpp"
#include "overlaps/hard_voxel.hpp"
#include "overlaps/soft_voxel.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "register_all.hpp"
#include "stores/flat_hash.hpp"

using namespace aslio;
using plugins::HardVoxel;
using plugins::SoftVoxel;

namespace {

template <class Params>
Params with_store(Params params) {
  auto recipe = std::make_shared<config::StageRecipe>();
  recipe->family = "stores";
  recipe->type = "flat_hash";
  recipe->make = [](const BuildContext& context) -> std::unique_ptr<Stage> {
    return std::make_unique<plugins::FlatHash>(plugins::FlatHash::Params{}, context);
  };
  params.store.resolve(recipe);
  return params;
}

/// Exactly representable voxels, no delay, every point counted.
template <class Params>
Params plain(double voxel = 0.25) {
  Params params;
  params.voxel = voxel;
  params.delay = 0;
  params.max_points = 0;
  params.min_points = 1;
  return with_store(params);
}

WorldPoint at(double x, double y, double z) {
  WorldPoint point;
  point.p_W = Vec3(x, y, z);
  return point;
}

std::vector<WorldPoint> cloud(std::size_t n, double half, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return half * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); };
  std::vector<WorldPoint> points(n);
  for (auto& point : points) {
    const double x = uniform(), y = uniform();
    point = at(x, y, uniform());
  }
  return points;
}

}  // namespace

TEST_CASE("soft overlap of points at known layers") {  // eq. SOD-2
  test::BuildEnvironment environment;
  SoftVoxel soft(plain<SoftVoxel::Params>(), environment.context());
  soft.extend(std::vector<WorldPoint>{at(0.1, 0.1, 0.1)}, 0);
  const std::vector<WorldPoint> frame{at(0.2, 0.0, 0.2), at(0.3, 0.1, -0.1), at(0.6, 0.1, 0.1), at(0.1, 0.1, -0.6),
                                      at(1.1, 0.1, 0.1)};
  const OverlapScore score = soft.evaluate(frame, 1);
  REQUIRE(score.points == 5);
  REQUIRE(score.layers == std::array<std::uint32_t, kMaxLayers>{1, 1, 1, 1, 0, 0, 0, 0});
  REQUIRE(*score.value == Approx((1.0 + 0.75 + 0.5 + 0.25) / 5.0).epsilon(1e-15));
}

TEST_CASE("cells are floors: around the origin no voxel is of double size") {  // eq. SOD-1
  test::BuildEnvironment environment;
  HardVoxel hard(plain<HardVoxel::Params>(1.0), environment.context());
  hard.extend(std::vector<WorldPoint>{at(0.5, 0.5, 0.5)}, 0);
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) {
        const double expected = x > 0 && y > 0 && z > 0 ? 1.0 : 0.0;
        REQUIRE(hard.evaluate(std::vector<WorldPoint>{at(x, y, z)}, 1).value == expected);
      }
    }
  }
}

TEST_CASE("a margin of no weight equals the hard overlap, any weight is no less") {  // eq. SOD-1
  test::BuildEnvironment environment;
  auto none = plain<SoftVoxel::Params>();
  none.beta = SoftVoxel::Beta::list;
  none.beta_list = {0.0, 0.0, 0.0};
  auto no_layers = plain<SoftVoxel::Params>();
  no_layers.layers = 0;
  HardVoxel hard(plain<HardVoxel::Params>(), environment.context());
  SoftVoxel zero(none, environment.context()), flat(no_layers, environment.context()),
      soft(plain<SoftVoxel::Params>(), environment.context());
  for (std::uint64_t round = 0; round < 20; ++round) {
    const auto frame = cloud(300, 2.0, 50 + round);
    const auto t = static_cast<TimeNs>(round);
    const auto expected = hard.evaluate(frame, t).value;
    REQUIRE(zero.evaluate(frame, t).value == expected);
    REQUIRE(flat.evaluate(frame, t).value == expected);
    const auto more = soft.evaluate(frame, t).value;
    REQUIRE(more.has_value() == expected.has_value());
    if (expected) REQUIRE(*more > *expected);
    const auto known = cloud(30, 2.0, round);
    for (OverlapMetric* metric : {static_cast<OverlapMetric*>(&hard), static_cast<OverlapMetric*>(&zero),
                                  static_cast<OverlapMetric*>(&flat), static_cast<OverlapMetric*>(&soft)}) {
      metric->extend(known, t);
    }
  }
}

TEST_CASE("weights: linear, geometric, listed, a margin in metres") {
  SoftVoxel::Params params;
  REQUIRE(SoftVoxel::weights(params) == std::vector<double>{1.0, 0.75, 0.5, 0.25});
  params.beta = SoftVoxel::Beta::geometric;
  params.layers = 2;
  REQUIRE(SoftVoxel::weights(params) == std::vector<double>{1.0, 0.5, 0.25});
  params.beta = SoftVoxel::Beta::list;
  params.beta_list = {0.9, 0.1};
  REQUIRE(SoftVoxel::weights(params) == std::vector<double>{1.0, 0.9, 0.1});
  params.layers.reset();
  params.margin_m = 0.3;
  REQUIRE(SoftVoxel::depth(params) == 3);
  params.voxel = 0.05;
  REQUIRE(SoftVoxel::depth(params) == 6);
  params.voxel = 0.2;  // 1.5 voxels
  REQUIRE(SoftVoxel::depth(params) == 2);
  params.voxel = 0.4;
  REQUIRE(SoftVoxel::depth(params) == 1);
}

TEST_CASE("moving everything by whole voxels changes no score") {
  test::BuildEnvironment environment;
  for (const LayerMetric metric : {LayerMetric::chebyshev, LayerMetric::manhattan, LayerMetric::euclid_rounded}) {
    auto params = plain<SoftVoxel::Params>();
    params.metric = metric;
    SoftVoxel here(params, environment.context()), there(params, environment.context());
    auto known = cloud(300, 3.0, 1), frame = cloud(1000, 3.0, 2);
    here.extend(known, 0);
    const OverlapScore expected = here.evaluate(frame, 1);
    const Vec3 shift(-1024.25, 2048.5, 4096.75);
    for (auto* points : {&known, &frame}) {
      for (auto& point : *points) point.p_W += shift;
    }
    there.extend(known, 0);
    const OverlapScore moved = there.evaluate(frame, 1);
    REQUIRE(moved.layers == expected.layers);
    REQUIRE(moved.value == expected.value);
    REQUIRE(*moved.value > 0.1);
    REQUIRE(*moved.value < 1.0);
  }
}

TEST_CASE("a point counts once it is `delay` older than the middle of the frame, to 5 ms") {
  test::BuildEnvironment environment;
  auto params = plain<HardVoxel::Params>();
  params.delay = 0.1;
  HardVoxel hard(params, environment.context());
  std::vector<WorldPoint> frame;
  for (int i = 1; i <= 1000; ++i) {
    frame.push_back(at(i, 0, 0));
    frame.back().t = i * kSecond / 10000;
  }
  const TimeNs end = kSecond / 10;
  hard.extend(frame, end);
  const auto score = [&](TimeNs t) { return hard.evaluate(frame, t).value.value_or(-1.0); };
  const auto about = [](double got, double expected) { return got <= expected && got > expected - 0.0511; };
  REQUIRE(score(end) == -1.0);                 // the occupancy of time 0
  REQUIRE(about(score(end + 40000000), 0.2));  // the middle is 20 ms after the end
  REQUIRE(about(score(end + kSecond / 10), 0.5));
  REQUIRE(about(score(end + 40000000), 0.2));
  // Updates that were not merged leave a frame that seems long: its middle is taken delay / 2 before its end.
  REQUIRE(score(end + 3 * kSecond / 20 - 1) < 1.0);
  REQUIRE(score(end + 3 * kSecond / 20) == 1.0);
  hard.extend({}, 2 * end);
  REQUIRE(score(2 * end) == 1.0);
}

TEST_CASE("shorter frames hide what is new from the score, unless it is delayed") {  // eq. SOD-3
  test::BuildEnvironment environment;
  // The view of 1 m moves along a wall at 2 m/s; a frame holds the points of the last step. Share of points unknown:
  const auto unknown = [&](double delay, int step_ms) {
    auto params = plain<HardVoxel::Params>(0.03125);
    params.delay = delay;
    HardVoxel hard(params, environment.context());
    std::mt19937_64 engine(1);
    const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
    double sum = 0;
    int scored = 0;
    for (int ms = step_ms; ms <= 4000; ms += step_ms) {
      std::vector<WorldPoint> frame;
      for (int i = 0; i < 50 * step_ms; ++i) {
        const double t = 0.001 * (ms - step_ms * uniform());
        frame.push_back(at(2.0 * t + uniform(), 0.01, 0.01));
        frame.back().t = to_ns(t);
      }
      std::sort(frame.begin(), frame.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
      const TimeNs now = ms * (kSecond / 1000);
      if (ms > 1000) {
        sum += 1.0 - hard.evaluate(frame, now).value.value();
        ++scored;
      }
      hard.extend(frame, now);
    }
    return sum / scored;
  };
  // At once: v * step / 2, which vanishes with the step. Delayed: v * delay.
  REQUIRE(unknown(0.0, 100) == Approx(0.1).margin(0.03));
  REQUIRE(unknown(0.0, 10) < 0.03);
  for (const int step_ms : {100, 70, 40, 10}) REQUIRE(unknown(0.1, step_ms) == Approx(0.2).margin(0.02));
}

TEST_CASE("metrics: the layer of a point three voxels along one, two or all axes") {
  test::BuildEnvironment environment;
  const auto layer = [&](LayerMetric metric, const WorldPoint& point) {
    auto params = plain<SoftVoxel::Params>();
    params.metric = metric;
    params.layers = 7;
    SoftVoxel soft(params, environment.context());
    soft.extend(std::vector<WorldPoint>{at(0.1, 0.1, 0.1)}, 0);
    const OverlapScore score = soft.evaluate(std::span(&point, 1), 1);
    const auto found = std::find(score.layers.begin(), score.layers.end(), 1U) - score.layers.begin();
    if (found < 8) REQUIRE(*score.value == Approx(1.0 - static_cast<double>(found) / 8.0).epsilon(1e-15));
    return static_cast<int>(found);  // 8: beyond the margin
  };
  const WorldPoint one = at(0.85, 0.1, 0.1), two = at(0.85, -0.7, 0.1), three = at(0.85, -0.7, 0.85);
  REQUIRE(layer(LayerMetric::chebyshev, one) == 3);
  REQUIRE(layer(LayerMetric::chebyshev, two) == 3);
  REQUIRE(layer(LayerMetric::chebyshev, three) == 3);
  REQUIRE(layer(LayerMetric::manhattan, one) == 3);
  REQUIRE(layer(LayerMetric::manhattan, two) == 6);
  REQUIRE(layer(LayerMetric::manhattan, three) == 8);
  REQUIRE(layer(LayerMetric::euclid_rounded, one) == 3);
  REQUIRE(layer(LayerMetric::euclid_rounded, two) == 4);
  REQUIRE(layer(LayerMetric::euclid_rounded, three) == 5);
}

TEST_CASE("points of the whole window: what is old is known, so that O = ((n - 2) + 2 O_new) / n") {
  test::BuildEnvironment environment;
  auto params = plain<HardVoxel::Params>();
  HardVoxel latest(params, environment.context());
  params.points = HardVoxel::Points::window;
  params.frame_length = 0.1;
  HardVoxel window(params, environment.context());
  // n = 10: an update every 20 ms, a fifth of its points at a place seen before.
  constexpr int kSteps = 30;
  for (int step = 1; step <= kSteps; ++step) {
    const TimeNs t = step * kSecond / 50;
    std::vector<WorldPoint> frame;
    for (int i = 0; i < 100; ++i) {
      frame.push_back(i % 5 == 0 ? at(0.1, 0.1, 0.1) : at(1.0 * i, 2.0 * step, 0.1));
      frame.back().t = t - kSecond / 50 + (i + 1) * kSecond / 5000;
    }
    if (step > 6) {
      const OverlapScore fresh = latest.evaluate(frame, t), all = window.evaluate(frame, t);
      REQUIRE(*fresh.value == Approx(0.2).epsilon(1e-12));
      REQUIRE(all.points == 500);
      REQUIRE(*all.value == Approx((8.0 + 2.0 * 0.2) / 10.0).epsilon(1e-12));
      // Half a step later half of the oldest points have left.
      REQUIRE(window.evaluate(frame, t + kSecond / 100).points == 450);
    }
    latest.extend(frame, t);
    window.extend(frame, t);
  }
}

TEST_CASE("the cap takes points evenly, whatever the scan lines") {
  test::BuildEnvironment environment;
  auto params = plain<HardVoxel::Params>(1.0);
  params.max_points = 1000;
  HardVoxel hard(params, environment.context());
  // Six lines take turns; the map knows one of them. A fixed stride of 6 would score 0 or 1.
  std::vector<WorldPoint> frame, known;
  for (int i = 0; i < 6000; ++i) frame.push_back(at(0.5, 10.0 * (i % 6) + 0.5, 0.5));
  known.push_back(frame.front());
  hard.extend(known, 0);
  const OverlapScore score = hard.evaluate(frame, 1);
  REQUIRE(score.points == 1000);
  REQUIRE(*score.value == Approx(1.0 / 6.0).margin(0.04));
}

TEST_CASE("soft overlap refuses parameters that contradict each other, naming the key") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  const auto context = environment.context();
  const auto refused = [&](const std::string& text, const std::string& key) {
    try {
      test::make_stage<OverlapMetric>(catalog, text, context);
    } catch (const ConfigError& error) {
      return std::string(error.what()).find(key) != std::string::npos;
    }
    return false;
  };
  REQUIRE(refused("{type: soft_voxel, layers: 2, margin_m: 0.2}", "margin_m"));
  REQUIRE(refused("{type: soft_voxel, layers: 2.5}", "layers"));
  REQUIRE(refused("{type: soft_voxel, layers: 8}", "layers"));
  REQUIRE(refused("{type: soft_voxel, margin_m: 0.8}", "margin_m"));
  REQUIRE(refused("{type: soft_voxel, voxel: 0.1, margin_m: 0.04}", "margin_m"));
  REQUIRE_FALSE(refused("{type: soft_voxel, voxel: 0.1, margin_m: 0}", "margin_m"));
  REQUIRE(refused("{type: soft_voxel, max_points: 40}", "max_points"));
  REQUIRE_FALSE(refused("{type: soft_voxel, max_points: 40, min_points: 40}", "max_points"));
  REQUIRE(refused("{type: soft_voxel, beta_list: [0.5, 0.4, 0.3]}", "beta_list"));
  REQUIRE(refused("{type: soft_voxel, beta: list, beta_list: [0.5, 0.4]}", "beta_list"));
  REQUIRE(refused("{type: soft_voxel, beta: list, beta_list: [0.5, 0.6, 0.3]}", "beta_list"));
  REQUIRE(refused("{type: soft_voxel, beta: list, beta_list: [1.0, 0.6, 0.3]}", "beta_list"));
  REQUIRE(refused("{type: soft_voxel, voxel: 0}", "voxel"));
  REQUIRE(test::make_stage<OverlapMetric>(catalog, "{type: soft_voxel, beta: list, beta_list: [0.5, 0.4, 0.3]}",
                                          context) != nullptr);
  REQUIRE(test::make_stage<OverlapMetric>(catalog, "{type: soft_voxel, margin_m: 0.7, metric: euclid}", context) !=
          nullptr);
}

TEST_CASE("what trimming would forget on the way is neither new nor known, again and again") {
  test::BuildEnvironment environment;
  SoftVoxel soft(plain<SoftVoxel::Params>(), environment.context());
  HardVoxel hard(plain<HardVoxel::Params>(), environment.context());
  const auto seen_from = [](double x) {  // half of it at 10 m, half of it 93 m away
    auto frame = cloud(1000, 1.0, 4);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      frame[i].p_W.x() += i % 2 == 0 ? 10 : 93;
      frame[i].range = static_cast<float>((frame[i].p_W - Vec3(x, 0, 0)).norm());
    }
    return frame;
  };
  for (OverlapMetric* metric : std::initializer_list<OverlapMetric*>{&soft, &hard}) {
    for (int k = 0; k <= 25; ++k) {
      const auto frame = seen_from(-k);
      const OverlapScore score = metric->evaluate(frame, k * kSecond);
      if (k > 0) {
        CAPTURE(k);
        REQUIRE(score.value == 1.0);
        REQUIRE(score.points == 500);
      }
      metric->extend(frame, k * kSecond);
      metric->trim(Vec3(-k, 0, 0), 100.0);
    }
  }
}
