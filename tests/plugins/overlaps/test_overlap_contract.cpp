// What every registered overlap metric promises (stages/overlap.hpp), with its default parameters.
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <random>

#include "aslio/stages/overlap.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

using namespace aslio;

namespace {

std::vector<WorldPoint> cloud(std::size_t n, double half, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return half * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); };
  std::vector<WorldPoint> points(n);
  for (auto& point : points) {
    point.p_W.x() = uniform();
    point.p_W.y() = uniform();
    point.p_W.z() = uniform();
  }
  return points;
}

void require_same(const OverlapScore& a, const OverlapScore& b) {
  REQUIRE(a.value == b.value);
  REQUIRE(a.layers == b.layers);
  REQUIRE(a.points == b.points);
}

void require_invariants(const OverlapScore& score) {
  REQUIRE(score.value.has_value());
  REQUIRE(*score.value >= 0.0);
  REQUIRE(*score.value <= 1.0);
  REQUIRE(std::accumulate(score.layers.begin(), score.layers.end(), 0U) <= score.points);
  REQUIRE((*score.value == 1.0) == (score.layers[0] == score.points));
}

/// Long enough for everything known to count.
constexpr TimeNs kLater = 1000 * kSecond;

template <class F>
void for_every_metric(F&& check) {
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
  const auto types = test::under_test(catalog, OverlapMetric::family);
  REQUIRE(!types.empty());
  for (const auto& type : types) {
    INFO(type);
    const auto context = environment.context();
    check([&] { return test::make_stage<OverlapMetric>(catalog, type, context); });
  }
}

}  // namespace

TEST_CASE("every overlap metric: invariants while the map grows, adding to it never lowers a score") {
  for_every_metric([](auto make) {
    const auto metric = make();
    const auto frame = cloud(3000, 1.0, 1);
    double previous = 0;
    for (std::uint64_t step = 0; step < 8; ++step) {
      const auto t = static_cast<TimeNs>(step) * kLater;
      metric->extend(cloud(200, 1.2, 100 + step), t);
      const OverlapScore score = metric->evaluate(frame, t + kLater);
      require_invariants(score);
      REQUIRE(*score.value >= previous);
      previous = *score.value;
    }
    REQUIRE(previous > 0.05);
  });
}

TEST_CASE("every overlap metric: undefined on an empty map, without points and with too few") {
  for_every_metric([](auto make) {
    const auto metric = make();
    const auto frame = cloud(1000, 1.0, 1);
    REQUIRE(!metric->evaluate(frame, 0).value);
    metric->extend(frame, 0);
    REQUIRE(!metric->evaluate({}, kLater).value);
    REQUIRE(!metric->evaluate(std::span(frame).first(5), kLater).value);
    REQUIRE(metric->evaluate(frame, kLater).value == 1.0);
  });
}

TEST_CASE("every overlap metric: evaluating changes nothing, also when it looks ahead") {
  for_every_metric([](auto make) {
    const auto quiet = make(), asked = make();
    for (int step = 0; step < 30; ++step) {
      const auto frame = cloud(300, 1.0 + 0.2 * step, static_cast<std::uint64_t>(step));
      const TimeNs t = step * kSecond / 50;
      require_same(asked->evaluate(frame, t), asked->evaluate(frame, t));
      asked->evaluate(frame, t + kSecond);
      asked->evaluate(frame, t + kSecond / 100);
      require_same(asked->evaluate(frame, t), quiet->evaluate(frame, t));
      asked->extend(frame, t);
      quiet->extend(frame, t);
    }
  });
}

TEST_CASE("every overlap metric: what it was asked makes no difference to what it learns") {
  for_every_metric([](auto make) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      CAPTURE(seed);
      const auto asked = make(), silent = make();
      TimeNs t = 0;
      const int steps = 10 + static_cast<int>(seed % 7);
      for (int step = 0; step < steps; ++step) {
        auto frame = cloud(400, 0.4, 1000 * seed + static_cast<std::uint64_t>(step));
        for (std::size_t i = 0; i < frame.size(); ++i) frame[i].t = t + static_cast<TimeNs>(i) * kSecond / 8000;
        t += kSecond / 20;
        asked->evaluate(frame, step % 4 == 3 ? t + kSecond / 10 : t);
        if (step % 3 == 1) {  // another frame is learnt than the one that was scored, in part
          for (std::size_t i = 0; i < frame.size(); i += 2) frame[i].p_W.x() += 0.3;
        }
        for (const auto& metric : {asked.get(), silent.get()}) {
          if (step == 8) metric->trim(Vec3(0.4, 0.4, 0.4), 0.3);
          if (step == 10 && seed % 2 == 0) metric->clear();
          metric->extend(frame, t);
        }
      }
      const auto probe = cloud(2000, 1.0, seed);
      for (TimeNs ahead = 0; ahead < kSecond / 2; ahead += kSecond / 100) {
        require_same(asked->evaluate(probe, t + ahead), silent->evaluate(probe, t + ahead));
      }
    }
  });
}

TEST_CASE("every overlap metric: announcing that time has advanced changes no score") {
  for_every_metric([](auto make) {
    const auto plain = make(), told = make();
    for (int step = 0; step < 30; ++step) {
      const auto frame = cloud(300, 1.0 + 0.2 * step, static_cast<std::uint64_t>(step));
      const TimeNs t = step * kSecond / 50;
      if (step % 3 != 0) told->evaluate(frame, t + kSecond / 30);
      told->advance(t);
      require_same(told->evaluate(frame, t), plain->evaluate(frame, t));
      plain->extend(frame, t);
      told->extend(frame, t);
    }
  });
}

TEST_CASE("every overlap metric: a frame scores 1 against itself once known, which is why it is scored before") {
  for_every_metric([](auto make) {
    const auto metric = make();
    metric->extend(cloud(500, 0.5, 1), 0);
    auto elsewhere = cloud(2000, 0.5, 2);
    for (auto& point : elsewhere) point.p_W.x() += 50.0;
    REQUIRE(metric->evaluate(elsewhere, kLater).value == 0.0);
    metric->extend(elsewhere, kLater);
    REQUIRE(metric->evaluate(elsewhere, 2 * kLater).value == 1.0);
  });
}

TEST_CASE("every overlap metric: points that are not finite or too far are not counted") {
  for_every_metric([](auto make) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const auto metric = make();
    auto frame = cloud(1000, 1.0, 1);
    metric->extend(frame, 0);
    for (const Vec3& bad : {Vec3(nan, 0, 0), Vec3(0, inf, 0), Vec3(0, 0, 1e30), Vec3(-1e9, 0, 0)}) {
      frame.push_back({});
      frame.back().p_W = bad;
    }
    metric->extend(frame, kSecond);
    const OverlapScore score = metric->evaluate(frame, kLater);
    REQUIRE(score.points == 1000);
    REQUIRE(score.value == 1.0);
  });
}

TEST_CASE("every overlap metric: trimming forgets what is far, keeps what is near and bounds the memory") {
  for_every_metric([](auto make) {
    const auto metric = make();
    const auto home = cloud(2000, 1.0, 1);
    metric->extend(home, 0);
    std::size_t early = 0;
    TimeNs t = 0;
    for (int step = 0; step < 1000; ++step) {
      auto frame = cloud(300, 1.0, 2);
      for (auto& point : frame) point.p_W.x() += step;
      t += kSecond;
      metric->extend(frame, t);
      metric->trim(Vec3(step, 0, 0), 30.0);
      if (step == 200) early = metric->memory_bytes();
      if (step == 20) REQUIRE(metric->evaluate(home, t).value == 1.0);
    }
    REQUIRE(metric->evaluate(home, t + kLater).value == 0.0);
    REQUIRE(metric->memory_bytes() < 2 * early);
  });
}

TEST_CASE("every overlap metric: after clear() it is as new") {
  for_every_metric([](const auto& make) {
    const auto used = make(), fresh = make();
    for (TimeNs t = 1; t <= 3; ++t) used->extend(cloud(2000, 3.0, static_cast<std::uint64_t>(t)), t * kSecond);
    REQUIRE(used->evaluate(cloud(1000, 3.0, 9), kLater).value.has_value());
    used->clear();
    REQUIRE_FALSE(used->evaluate(cloud(1000, 3.0, 9), kLater).value.has_value());
    for (const auto& metric : {used.get(), fresh.get()}) metric->extend(cloud(2000, 3.0, 5), 2 * kLater);
    require_same(used->evaluate(cloud(1000, 3.0, 9), 3 * kLater), fresh->evaluate(cloud(1000, 3.0, 9), 3 * kLater));
  });
}
