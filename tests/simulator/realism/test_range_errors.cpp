/// Systematic errors of ranges, and noise that grows.

#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/simulator/return_model.hpp"
#include "lidar/range_errors.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

const RangingRealism kAll{.offset = 0.02,
                          .line = 0.005,
                          .incidence = 0.05,
                          .reflectivity = 0.015,
                          .near = 0.02,
                          .warm_up = 0.01,
                          .noise_growth = 2};

double cosine(double degrees) { return std::cos(degrees * kRadPerDeg); }

}  // namespace

TEST_CASE("the errors of a sensor are within their bounds and belong to its seed", "[realism]") {
  double lowest = 1, highest = -1;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const RangeErrors errors(kAll, seed), again(kAll, seed);
    const double first = errors.standing(0, 0), second = errors.standing(1, 0), warm = errors.standing(0, 3000);
    CHECK(first == again.standing(0, 0));
    CHECK(std::abs(first) <= 0.025);
    CHECK(std::abs(second - first) <= 0.010);
    CHECK(std::abs(warm - first) <= 0.010);
    lowest = std::min(lowest, first);
    highest = std::max(highest, first);
  }
  CHECK(lowest < -0.015);
  CHECK(highest > 0.015);
}

TEST_CASE("lines differ, and the sensor warms with its time constant", "[realism]") {
  const RangeErrors errors(kAll, 3);
  CHECK(errors.standing(0, 0) != errors.standing(5, 0));
  const double all = errors.standing(2, 1e6) - errors.standing(2, 0);
  CHECK(errors.standing(2, 300) - errors.standing(2, 0) == Approx((1 - std::exp(-1.0)) * all));
}

TEST_CASE("a grazing footprint makes ranges too short, by 0.2 m at most", "[realism]") {
  const RangeErrors errors({.incidence = 0.05}, 1);
  CHECK(errors.of_echo(10, cosine(80), 0.5) == Approx(-0.05));
  CHECK(errors.of_echo(20, cosine(80), 0.5) == Approx(-0.10));
  CHECK(errors.of_echo(10, 1, 0.5) == Approx(0).margin(1e-12));
  CHECK(errors.of_echo(10, cosine(60), 0.5) == Approx(-0.05 * std::tan(60 * kRadPerDeg) / std::tan(80 * kRadPerDeg)));
  CHECK(errors.of_echo(100, 0, 0.5) == Approx(-0.2));
}

TEST_CASE("near ranges and dark surfaces have errors of their own", "[realism]") {
  const RangeErrors near({.near = 0.02}, 4), dark({.reflectivity = 0.015}, 4);
  const double at_zero = near.of_echo(0, 1, 1);
  CHECK(at_zero != 0);
  CHECK(near.of_echo(1, 1, 1) == Approx(0.25 * at_zero));
  CHECK(near.of_echo(2.5, 1, 1) == 0);
  CHECK(dark.of_echo(5, 1, 0.1) == Approx(0.9 * dark.of_echo(5, 1, 0)));
  CHECK(dark.of_echo(5, 1, 1) == 0);
}

TEST_CASE("without realism a range has its random error alone", "[realism]") {
  const RangeErrors none({}, 7);
  CHECK(none.standing(3, 500) == 0);
  CHECK(none.of_echo(0.5, cosine(85), 0.05) == 0);
  CHECK(none.noise(90, 90) == 1);
}

TEST_CASE("the noise of an echo grows to its end of reach", "[realism]") {
  LidarParams params;
  params.dropout = params.outliers = params.mixed = 0;
  const SensorFacts& avia = facts(SensorKind::avia);
  Realism realism;
  realism.ranging.noise_growth = 2;
  const auto deviation = [&](double range) {
    ReturnModel model(params, avia, 1, 0, realism);
    double sum = 0, squares = 0;
    int count = 0;
    for (int k = 0; k < 40'000; ++k) {
      const auto back = model.receive(model.emit({}), {.range = range, .cos_incidence = 1, .reflectivity = 0.1}, {});
      if (!back) continue;
      sum += back->range - range;
      squares += (back->range - range) * (back->range - range);
      ++count;
    }
    REQUIRE(count > 30'000);
    const double mean = sum / count;
    return std::sqrt(squares / count - mean * mean);
  };
  // weak_range is 90 m for this surface.
  CHECK(deviation(1) == Approx(0.02).epsilon(0.03));
  CHECK(deviation(45) == Approx(0.02 * 1.5).epsilon(0.03));
  CHECK(deviation(90) == Approx(0.02 * 3).epsilon(0.03));
}

TEST_CASE("with a footprint every pulse has a second direction within its ellipse", "[realism]") {
  const SensorFacts& avia = facts(SensorKind::avia);
  Realism realism;
  realism.footprint = 1;
  LidarParams params;
  params.angle_noise = 0;
  ReturnModel model(params, avia, 1, 0, realism);
  double widest_azimuth = 0, widest_elevation = 0;
  for (int k = 0; k < 10'000; ++k) {
    const Beam beam;
    const Pulse pulse = model.emit(beam);
    REQUIRE(pulse.mixed);
    widest_azimuth = std::max(widest_azimuth, std::abs(pulse.second.dot(beam.azimuth)));
    widest_elevation = std::max(widest_elevation, std::abs(pulse.second.dot(beam.elevation)));
  }
  CHECK(widest_azimuth == Approx(0.5 * 0.03 * kRadPerDeg).epsilon(0.01));
  CHECK(widest_elevation == Approx(0.5 * 0.28 * kRadPerDeg).epsilon(0.01));
}
