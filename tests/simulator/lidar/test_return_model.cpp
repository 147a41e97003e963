#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/simulator/return_model.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr int kPulses = 200'000;

const SensorFacts& avia() { return facts(SensorKind::avia); }

/// A surface seen straight on.
SurfaceHit surface(double range, double reflectivity = 0.5, double incidence = 0) {
  return {.range = range, .cos_incidence = std::cos(incidence * kDeg), .reflectivity = reflectivity, .moving = false};
}

/// Nothing goes wrong at random.
LidarParams sound() {
  LidarParams params;
  params.dropout = params.outliers = params.mixed = 0;
  return params;
}

ReturnModel model(const LidarParams& params, std::uint64_t seed = 1, std::uint64_t packet = 0) {
  return ReturnModel(params, avia(), seed, packet);
}

struct Moments {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

/// Share of pulses that come back from a surface.
double share_back(const LidarParams& params, const SurfaceHit& hit, int pulses = 50'000) {
  ReturnModel m = model(params);
  int back = 0;
  for (int k = 0; k < pulses; ++k) back += m.receive(m.emit({}), hit, {}) ? 1 : 0;
  return static_cast<double>(back) / pulses;
}

bool same(const Pulse& a, const Pulse& b) {
  return a.direction == b.direction && a.second == b.second && a.lost == b.lost && a.mixed == b.mixed &&
         a.range_error == b.range_error && a.keep == b.keep && a.outlier_range == b.outlier_range && a.mix == b.mix;
}

}  // namespace

TEST_CASE("errors of ranges and directions have the given deviations and no bias") {
  const bool of_sensor = GENERATE(true, false);
  LidarParams params = sound();
  if (!of_sensor) {
    params.range_noise = 0.05;
    params.angle_noise = 0.3;
  }
  const double range_noise = of_sensor ? avia().range_noise : 0.05;
  const double angle_noise = of_sensor ? avia().angle_noise : 0.3 * kDeg;
  Beam beam;
  beam.direction = Vec3(0.6, 0, 0.8);
  beam.elevation = Vec3(-0.8, 0, 0.6);
  ReturnModel m = model(params);
  Moments range, azimuth, elevation, product;
  for (int k = 0; k < kPulses; ++k) {
    const Pulse pulse = m.emit(beam);
    REQUIRE(pulse.direction.norm() == Approx(1).epsilon(1e-12));
    const double along = pulse.direction.dot(beam.direction);
    azimuth.add(pulse.direction.dot(beam.azimuth) / along);
    elevation.add(pulse.direction.dot(beam.elevation) / along);
    const auto report = m.receive(pulse, surface(10), {});
    REQUIRE(report);
    range.add(report->range - 10);
    product.add((report->range - 10) / range_noise * pulse.direction.dot(beam.azimuth) / angle_noise);
  }
  const double root = std::sqrt(kPulses);
  CHECK(range.deviation() == Approx(range_noise).epsilon(0.03));
  CHECK(azimuth.deviation() == Approx(angle_noise).epsilon(0.03));
  CHECK(elevation.deviation() == Approx(angle_noise).epsilon(0.03));
  CHECK(std::abs(range.mean()) < 4 * range_noise / root);
  CHECK(std::abs(azimuth.mean()) < 4 * angle_noise / root);
  CHECK(std::abs(elevation.mean()) < 4 * angle_noise / root);
  CHECK(std::abs(product.mean()) < 4 / root);
}

TEST_CASE("the given share of pulses is lost at random") {
  for (const double dropout : {0.0, 0.02, 0.3, 1.0}) {
    CAPTURE(dropout);
    LidarParams params = sound();
    params.dropout = dropout;
    CHECK(share_back(params, surface(10)) == Approx(1 - dropout).margin(4 * std::sqrt(dropout / 50'000)));
  }
}

TEST_CASE("returns are lost at grazing incidence: none before it begins, all where it ends") {
  CHECK(share_back(sound(), surface(10, 0.5, 69.9)) == 1);
  CHECK(share_back(sound(), surface(10, 0.5, 80.1)) == 0);
  double before = 1;
  for (const double incidence : {72.0, 74.0, 76.0, 78.0, 79.5}) {
    CAPTURE(incidence);
    const double back = share_back(sound(), surface(10, 0.5, incidence));
    const double expected =
        (std::cos(incidence * kDeg) - std::cos(80 * kDeg)) / (std::cos(70 * kDeg) - std::cos(80 * kDeg));
    CHECK(back == Approx(expected).margin(0.01));
    CHECK(back < before);
    before = back;
  }
  LidarParams params = sound();
  params.grazing_begin = 20;
  params.grazing_end = 40;
  CHECK(share_back(params, surface(10, 0.5, 19)) == 1);
  CHECK(share_back(params, surface(10, 0.5, 30)) > 0.3);
  CHECK(share_back(params, surface(10, 0.5, 30)) < 0.7);
  CHECK(share_back(params, surface(10, 0.5, 41)) == 0);
}

TEST_CASE("weak surfaces are lost beyond a range that grows with the square root of what they send back") {
  for (const double reflectivity : {0.02, 0.1, 0.3}) {
    const double reach = 90 * std::sqrt(reflectivity / 0.1);
    CAPTURE(reflectivity, reach);
    CHECK(share_back(sound(), surface(0.99 * reach, reflectivity)) == 1);
    CHECK(share_back(sound(), surface(1.15 * reach, reflectivity)) == Approx(0.5).margin(0.02));
    CHECK(share_back(sound(), surface(1.31 * reach, reflectivity)) == 0);
  }
  // At 60 deg half of the light is sent back.
  CHECK(share_back(sound(), surface(0.99 * 90, 0.2, 60)) == 1);
  CHECK(share_back(sound(), surface(1.31 * 90, 0.2, 60)) == 0);
  CHECK(share_back(sound(), surface(5, 0)) == 0);
  CHECK(share_back(sound(), {}) == 0);
}

TEST_CASE("nothing is reported nearer than the shortest range or beyond the longest") {
  LidarParams params = sound();
  params.min_range = 2;
  params.max_range = 30;
  ReturnModel m = model(params);
  CHECK(m.min_range() == 2);
  CHECK(m.max_range() == 30);
  int near = 0, far = 0;
  for (int k = 0; k < 10'000; ++k) {
    const Pulse pulse = m.emit({});
    for (const double range : {1.9, 2.0, 2.1, 29.9, 30.0, 30.1}) {
      const auto report = m.receive(pulse, surface(range), {});
      const bool expected = range + pulse.range_error >= 2 && range + pulse.range_error <= 30;
      REQUIRE(report.has_value() == expected);
      if (range == 2.0) near += report ? 1 : 0;
      if (range == 30.0) far += report ? 1 : 0;
    }
  }
  CHECK(near == Approx(5000).margin(250));
  CHECK(far == Approx(5000).margin(250));
  CHECK(model(sound()).min_range() == avia().min_range);
  CHECK(model(sound()).max_range() == avia().max_range);
}

TEST_CASE("intensity is that of a Lambertian surface: its reflectivity times the cosine of the incidence") {
  ReturnModel m = model(sound());
  for (const double reflectivity : {0.1, 0.5, 1.0})
    for (const double incidence : {0.0, 30.0, 60.0, 69.0})
      for (const double range : {1.0, 20.0, 40.0}) {
        CAPTURE(reflectivity, incidence, range);
        const auto report = m.receive(m.emit({}), surface(range, reflectivity, incidence), {});
        REQUIRE(report);
        CHECK(report->intensity == Approx(255 * reflectivity * std::cos(incidence * kDeg)).margin(0.51));
        CHECK(report->tag == 0x10);
      }
}

TEST_CASE("mixed pixels lie between the two surfaces of a small step, and on the nearer one of a large step") {
  LidarParams params = sound();
  params.mixed = 0.25;
  params.range_noise = 0;
  ReturnModel m = model(params);
  const auto shares = [&](double near, double far) {
    int between = 0, on_near = 0, on_far = 0;
    for (int k = 0; k < 40'000; ++k) {
      const Pulse pulse = m.emit({});
      // Half of the beams meet the near surface, the other half of their footprint the far one.
      const bool first_near = k % 2 == 0;
      const auto report = m.receive(pulse, surface(first_near ? near : far), surface(first_near ? far : near));
      REQUIRE(report);
      REQUIRE(report->range >= near);
      REQUIRE(report->range <= far);
      on_near += report->range == near ? 1 : 0;
      on_far += report->range == far ? 1 : 0;
      between += report->range > near && report->range < far ? 1 : 0;
    }
    return std::array<double, 3>{on_near / 40e3, between / 40e3, on_far / 40e3};
  };
  const auto small = shares(10, 10.8);
  CHECK(small[0] == Approx(0.375).margin(0.01));
  CHECK(small[1] == Approx(0.25).margin(0.01));
  CHECK(small[2] == Approx(0.375).margin(0.01));
  const auto large = shares(10, 15);
  CHECK(large[0] == Approx(0.625).margin(0.01));
  CHECK(large[1] == 0);
  const auto same_surface = shares(10, 10.1);
  CHECK(same_surface[1] == 0);
  CHECK(same_surface[0] == Approx(0.5).margin(0.01));
}

TEST_CASE("the second direction of a mixed pixel stays within the footprint") {
  LidarParams params = sound();
  params.mixed = 0.5;
  params.angle_noise = 0;
  ReturnModel m = model(params);
  int mixed = 0;
  Moments azimuth;
  for (int k = 0; k < 50'000; ++k) {
    const Pulse pulse = m.emit({});
    if (!pulse.mixed) continue;
    ++mixed;
    REQUIRE(pulse.second.norm() == Approx(1).epsilon(1e-12));
    REQUIRE(std::abs(pulse.second.y()) <= avia().beam_divergence / 2 * 1.0001);
    REQUIRE(std::abs(pulse.second.z()) <= avia().beam_divergence / 2 * 1.0001);
    azimuth.add(pulse.second.y());
  }
  CHECK(mixed == Approx(25'000).margin(500));
  CHECK(azimuth.deviation() == Approx(avia().beam_divergence / std::sqrt(12)).epsilon(0.03));
}

TEST_CASE("at the edge of a wall the model reports the wall, what is behind it, or a point in between") {
  MeshBuilder builder;
  builder.wall({5, -5}, {5, 0}, -5, 5, 130);
  builder.wall({5.7, -5}, {5.7, 5}, -5, 5, 130);
  const Caster caster(builder.take());
  LidarParams params = sound();
  params.mixed = 1;
  params.range_noise = 0;
  ReturnModel m = model(params);
  int near = 0, between = 0, far = 0;
  for (int k = 0; k < 20'000; ++k) {
    const Pulse pulse = m.emit({});
    const auto report =
        m.receive(pulse, caster.cast(Vec3::Zero(), pulse.direction, 100), caster.cast(Vec3::Zero(), pulse.second, 100));
    REQUIRE(report);
    REQUIRE(report->range > 5 - 1e-3);
    REQUIRE(report->range < 5.7 + 1e-3);
    (report->range < 5.001 ? near : report->range > 5.699 ? far : between) += 1;
  }
  CHECK(near > 4000);
  CHECK(far > 4000);
  CHECK(between > 4000);
}

TEST_CASE("outliers are the given share of returns, evenly spread before the surface") {
  LidarParams params = sound();
  params.range_noise = 0;
  params.outliers = 0.2;
  ReturnModel m = model(params);
  Moments place;
  for (int k = 0; k < kPulses; ++k) {
    const auto report = m.receive(m.emit({}), surface(20.5), {});
    REQUIRE(report);
    REQUIRE(report->range >= avia().min_range);
    REQUIRE(report->range <= 20.5);
    if (report->range < 20.5) place.add((report->range - 0.5) / 20);
  }
  CHECK(place.count == Approx(0.2 * kPulses).epsilon(0.03));
  CHECK(place.mean() == Approx(0.5).margin(0.01));
  CHECK(place.deviation() == Approx(1 / std::sqrt(12)).epsilon(0.02));
}

TEST_CASE("without noise reports are exact") {
  LidarParams params;
  params.noise = false;
  ReturnModel m = model(params);
  Beam beam;
  beam.direction = Vec3(0.6, 0, 0.8);
  beam.elevation = Vec3(-0.8, 0, 0.6);
  for (int k = 0; k < 1000; ++k) {
    const Pulse pulse = m.emit(beam);
    REQUIRE(pulse.direction == beam.direction);
    REQUIRE_FALSE(pulse.mixed);
    const auto report = m.receive(pulse, surface(7.25, 0.5, 75), surface(7.9));
    REQUIRE(report);
    REQUIRE(report->range == 7.25);
    REQUIRE_FALSE(m.receive(pulse, surface(7.25, 0.5, 81), {}));
  }
}

TEST_CASE("a beam draws the same whatever the others met and whatever else goes wrong") {
  LidarParams all;
  all.dropout = all.outliers = all.mixed = 0.5;
  ReturnModel a = model(all, 3, 8), b = model(all, 3, 8);
  LidarParams fewer = all;
  fewer.dropout = 0;
  ReturnModel never_lost = model(fewer, 3, 8);
  fewer = all;
  fewer.mixed = fewer.outliers = 0;
  fewer.range_noise = 0;
  ReturnModel plain = model(fewer, 3, 8);
  for (int k = 0; k < 5000; ++k) {
    const Pulse p = a.emit({}), q = b.emit({});
    a.receive(p, surface(k % 2 == 0 ? 10 : std::numeric_limits<double>::infinity()), surface(11));
    REQUIRE(same(p, q));
    Pulse r = never_lost.emit({});
    r.lost = p.lost;
    REQUIRE(same(p, r));
    const Pulse s = plain.emit({});
    REQUIRE(s.direction == p.direction);
    REQUIRE(s.lost == p.lost);
    REQUIRE(s.keep == p.keep);
  }
}

TEST_CASE("packets and seeds have draws of their own") {
  ReturnModel first = model(sound(), 1, 0), next = model(sound(), 1, 1), other = model(sound(), 2, 0);
  Moments packets, seeds;
  for (int k = 0; k < 50'000; ++k) {
    const double a = first.emit({}).range_error / 0.02;
    packets.add(a * next.emit({}).range_error / 0.02);
    seeds.add(a * other.emit({}).range_error / 0.02);
  }
  CHECK(std::abs(packets.mean()) < 4 / std::sqrt(50e3));
  CHECK(std::abs(seeds.mean()) < 4 / std::sqrt(50e3));
}

TEST_CASE("time of a beam without its ray") {
  const auto pattern = make_scan_pattern(SensorKind::avia);
  ReturnModel m = model({});
  std::vector<Beam> beams(6);
  double cpu = 0;
  int back = 0;
  {
    const CpuTimer timer(cpu);
    for (TimeNs t = 0; t < kSecond; t += pattern->firing_period()) {
      pattern->fire(t, beams);
      for (const Beam& beam : beams) back += m.receive(m.emit(beam), surface(10), surface(10)) ? 1 : 0;
    }
  }
  CHECK(back > 200'000);
  CHECK(cpu < 0.5);
  WARN(1e9 * cpu / 240e3 << " ns per beam");
}
