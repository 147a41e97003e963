// The noise of ranges that a run sees, and what follows from it (eq. NOI-1, NOI-2).
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "aslio/pipeline/range_noise.hpp"

using namespace aslio;
using namespace aslio::pipeline;

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;

/// Points of six lines that sweep over a wall 5 m away; `clutter`: share of the points that lie anywhere.
std::vector<TimedPoint> wall(double sigma, double seconds, double clutter = 0, std::uint64_t seed = 1) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<TimedPoint> points;
  const TimeNs step = 25'000;
  bool cluttered = false;
  for (TimeNs t = 0; t < to_ns(seconds); t += step) {
    // A stretch of 1 ms is clutter or it is not.
    if (t % 1'000'000 == 0) cluttered = uniform(engine) < clutter;
    for (std::uint8_t line = 0; line < 6; ++line) {
      const double angle = 0.6 * std::sin(300.0 * to_seconds(t)) + 0.01 * line;
      const double range = 5.0 / std::cos(angle) + sigma * noise(engine) + (cluttered ? 2.0 * uniform(engine) : 0.0);
      TimedPoint point;
      point.x = static_cast<float>(range * std::cos(angle));
      point.y = static_cast<float>(range * std::sin(angle));
      point.t = kEpoch + t;
      point.line = line;
      points.push_back(point);
    }
  }
  return points;
}

double seen(double sigma, double clutter = 0) {
  RangeNoise noise({}, SensorModel{});
  noise.observe(wall(sigma, 2.0, clutter));
  REQUIRE(noise.range_sigma_seen());
  return *noise.range_sigma_seen();
}

RangeNoiseParams tuned() {
  RangeNoiseParams params;
  params.tuned_for = 0.02;
  return params;
}

}  // namespace

TEST_CASE("range noise: what a wall scatters is measured, half of clutter or none") {
  for (const double sigma : {0.01, 0.02, 0.03, 0.045, 0.06}) {
    CAPTURE(sigma);
    CHECK(seen(sigma) == Approx(sigma).epsilon(0.05));
    const double with_clutter = seen(sigma, 0.5) / sigma;
    CHECK(with_clutter > 0.97);
    CHECK(with_clutter < 1.4);
  }
}

TEST_CASE("range noise: nothing is said of too few points") {
  RangeNoise noise(tuned(), SensorModel{});
  noise.observe(wall(0.06, 0.05));
  CHECK_FALSE(noise.range_sigma_seen());
  CHECK(noise.scale() == 1.0);
}

TEST_CASE("range noise: within the dead band the factor is exactly one") {
  for (const double sigma : {0.005, 0.01, 0.02, 0.025}) {
    RangeNoise noise(tuned(), SensorModel{});
    noise.observe(wall(sigma, 2.0));
    CHECK(noise.scale() == 1.0);
  }
}

TEST_CASE("range noise: clearly more than declared is followed in steps, up to four times") {
  for (const double sigma : {0.03, 0.045, 0.06, 0.2}) {
    RangeNoise noise(tuned(), SensorModel{});
    noise.observe(wall(sigma, 2.0));
    CAPTURE(sigma);
    CHECK(noise.scale() == Approx(std::min(sigma / 0.02, 4.0)).epsilon(0.08));
    CHECK(std::remainder(noise.scale(), 0.125) == 0.0);
  }
}

TEST_CASE("range noise: what the sensor file declares counts without a measurement") {
  SensorModel sensor;
  sensor.range_sigma = 0.06;
  CHECK(RangeNoise(tuned(), sensor).scale() == Approx(3.0));
  CHECK(RangeNoise({}, sensor).scale() == 1.0);  // lengths of a file that names no noise are absolute
  RangeNoise noise(tuned(), sensor);
  noise.observe(wall(0.06, 2.0));
  CHECK(noise.scale() == Approx(3.0));
}

TEST_CASE("range noise: adapt: false reports and changes nothing") {
  RangeNoiseParams params = tuned();
  params.adapt = false;
  RangeNoise noise(params, SensorModel{});
  noise.observe(wall(0.06, 2.0));
  CHECK(noise.scale() == 1.0);
  CHECK(*noise.range_sigma_seen() > 0.05);
}

TEST_CASE("range noise: noise that has passed is forgotten") {
  RangeNoise noise(tuned(), SensorModel{});
  noise.observe(wall(0.06, 2.0));
  REQUIRE(noise.scale() > 2.5);
  std::vector<TimedPoint> later = wall(0.02, 60.0);
  for (TimedPoint& point : later) point.t += 10 * kSecond;
  noise.observe(later);
  CHECK(noise.scale() == 1.0);
}
