#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "aslio/simulator/avia.hpp"
#include "aslio/simulator/scan_pattern.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr SensorKind kKinds[] = {SensorKind::avia,   SensorKind::mid360, SensorKind::spin16,
                                 SensorKind::spin32, SensorKind::spin64, SensorKind::mid40};
constexpr SensorKind kSpinning[] = {SensorKind::spin16, SensorKind::spin32, SensorKind::spin64};

double azimuth(const Beam& beam) { return std::atan2(beam.direction.y(), beam.direction.x()) / kDeg; }
double elevation(const Beam& beam) { return std::asin(beam.direction.z()) / kDeg; }

/// Cells of an area of directions [deg] and which of them have been hit.
class Cells {
 public:
  Cells(double cell, double half_width, double low, double high)
      : cell_(cell),
        low_(low),
        half_width_(half_width),
        columns_(static_cast<int>(std::ceil(2 * half_width / cell))),
        rows_(static_cast<int>(std::ceil((high - low) / cell))),
        seen_(static_cast<std::size_t>(columns_ * rows_), 0) {}

  void hit(const Beam& beam) {
    const int column = static_cast<int>(std::floor((azimuth(beam) + half_width_) / cell_));
    const int row = static_cast<int>(std::floor((elevation(beam) - low_) / cell_));
    if (column >= 0 && column < columns_ && row >= 0 && row < rows_)
      seen_[static_cast<std::size_t>(row * columns_ + column)] = 1;
  }
  /// In per cent of the cells whose middle (azimuth, elevation) is in the field of view.
  template <class InView>
  double share(InView in_view) const {
    int cells = 0, hits = 0;
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        if (!in_view((column + 0.5) * cell_ - half_width_, (row + 0.5) * cell_ + low_)) continue;
        ++cells;
        hits += seen_[static_cast<std::size_t>(row * columns_ + column)];
      }
    return 100.0 * hits / cells;
  }

 private:
  double cell_, low_, half_width_;
  int columns_, rows_;
  std::vector<char> seen_;
};

void fire_all(const ScanPattern& pattern, TimeNs begin, double duration, Cells& cells) {
  std::vector<Beam> beams(pattern.beams_per_firing());
  const TimeNs period = pattern.firing_period(), end = begin + to_ns(duration);
  for (TimeNs t = begin; t < end; t += period) {
    pattern.fire(t, beams);
    for (const Beam& beam : beams) cells.hit(beam);
  }
}

/// Of half-degree cells in the ellipse of the field of view; mean over ten times.
double avia_coverage(double duration) {
  const auto pattern = make_scan_pattern(SensorKind::avia);
  double sum = 0;
  for (int i = 0; i < 10; ++i) {
    Cells cells(0.5, 35.5, -39, 39);
    fire_all(*pattern, TimeNs{370'000'000} * i, duration, cells);
    sum += cells.share([](double a, double e) {
      return std::hypot(a / (avia::kFovHorizontal / 2), e / (avia::kFovVertical / 2)) <= 1;
    });
  }
  return sum / 10;
}

double mid360_coverage(TimeNs begin, double duration) {
  const auto pattern = make_scan_pattern(SensorKind::mid360);
  Cells cells(0.5, 180, -7, 52);
  fire_all(*pattern, begin, duration, cells);
  return cells.share([](double, double) { return true; });
}

}  // namespace

TEST_CASE("the Avia covers its field of view over time as tabulated") {
  const std::pair<double, double> table[] = {{0.008, 7.8}, {0.02, 16.9}, {0.05, 35.6}, {0.1, 57.7},
                                             {0.2, 80.9},  {0.5, 93.1},  {1, 94.9}};
  for (const auto& [duration, percent] : table) {
    CAPTURE(duration);
    const double found = avia_coverage(duration);
    CHECK(std::abs(found - percent) < 3);
    WARN("Avia, " << duration << " s: " << found << " % (" << percent << ")");
  }
}

TEST_CASE("the Avia fires six lines 240 000 times per second along the two-prism rosette") {
  const auto pattern = make_scan_pattern(SensorKind::avia);
  CHECK(pattern->message() == LidarMessage::livox_custom);
  REQUIRE(pattern->beams_per_firing() == 6);
  CHECK(pattern->beams_per_firing() * static_cast<std::size_t>(kSecond / pattern->firing_period()) == 240'000);
  std::vector<Beam> beams(6);
  for (TimeNs t = 0; t < 30 * kSecond; t += 25'193'877) {
    pattern->fire(t, beams);
    const auto expected = avia::firing(to_seconds(t));
    for (std::size_t line = 0; line < 6; ++line) {
      REQUIRE((beams[line].direction - expected[line].direction).norm() < 1e-14);
      REQUIRE((beams[line].azimuth - expected[line].azimuth).norm() < 1e-14);
      REQUIRE((beams[line].elevation - expected[line].elevation).norm() < 1e-14);
      REQUIRE(elevation(beams[line]) == Approx(elevation(beams[0]) + 1.4 * static_cast<double>(line)).margin(1e-9));
    }
  }
}

TEST_CASE("the Mid-360 sees all round over 59 deg with 200 000 points per second, ever denser") {
  const auto pattern = make_scan_pattern(SensorKind::mid360);
  CHECK(pattern->message() == LidarMessage::livox_custom);
  REQUIRE(pattern->beams_per_firing() == 4);
  CHECK(pattern->beams_per_firing() * static_cast<std::size_t>(kSecond / pattern->firing_period()) == 200'000);
  std::vector<Beam> beams(4);
  double low = 90, high = -90;
  for (TimeNs t = 0; t < kSecond; t += pattern->firing_period()) {
    pattern->fire(t, beams);
    for (const Beam& beam : beams) {
      low = std::min(low, elevation(beam));
      high = std::max(high, elevation(beam));
    }
  }
  CHECK(low == Approx(-7).margin(0.1));
  CHECK(high == Approx(52).margin(0.1));
  double before = 0;
  for (const double duration : {0.1, 0.2, 0.4, 0.8, 1.6}) {
    const double found = mid360_coverage(0, duration);
    WARN("Mid-360, " << duration << " s: " << found << " % of cells of half a degree");
    CHECK(found > before + 3);
    before = found;
  }
  CHECK(before > 95);
  CHECK(mid360_coverage(100 * kSecond, 0.2) == Approx(mid360_coverage(0, 0.2)).margin(5));
}

TEST_CASE("the Mid-40 fires one beam 100 000 times per second over a round view of 38.4 deg, ever denser") {
  const auto pattern = make_scan_pattern(SensorKind::mid40);
  CHECK(pattern->message() == LidarMessage::livox_custom);
  REQUIRE(pattern->beams_per_firing() == 1);
  CHECK(kSecond / pattern->firing_period() == 100'000);
  const auto in_view = [](double a, double e) { return std::hypot(a, e) <= 19.2; };
  double before = 0;
  for (const double duration : {0.05, 0.1, 0.2, 0.5, 1.0}) {
    Cells cells(0.5, 20, -20, 20);
    fire_all(*pattern, 0, duration, cells);
    const double found = cells.share(in_view);
    WARN("Mid-40, " << duration << " s: " << found << " % of cells of half a degree");
    CHECK(found > before);
    before = found;
  }
  CHECK(before > 90);
  std::vector<Beam> beam(1);
  double widest = 0;
  for (TimeNs t = 0; t < 10 * kSecond; t += pattern->firing_period()) {
    pattern->fire(t, beam);
    widest = std::max(widest, std::hypot(azimuth(beam[0]), elevation(beam[0])));
  }
  CHECK(widest == Approx(19.2).margin(0.05));
}

TEST_CASE("rings of the spinning sensors lie at their elevations and turn ten times per second, clockwise") {
  const double lowest[] = {-15, -30.67, -24.8}, highest[] = {15, 10.67, 2};
  const std::size_t rings[] = {16, 32, 64};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto pattern = make_scan_pattern(kSpinning[i]);
    CAPTURE(rings[i]);
    CHECK(pattern->message() == LidarMessage::point_cloud2);
    REQUIRE(pattern->beams_per_firing() == rings[i]);
    const auto columns = static_cast<int>(kSecond / 10 / pattern->firing_period());
    CHECK(columns * pattern->firing_period() == kSecond / 10);
    std::vector<Beam> beams(rings[i]), later(rings[i]);
    for (int column = 0; column < 2 * columns; ++column) {
      pattern->fire(column * pattern->firing_period(), beams);
      pattern->fire(column * pattern->firing_period() + kSecond, later);
      for (std::size_t k = 0; k < rings[i]; ++k) {
        const double spacing = (highest[i] - lowest[i]) / static_cast<double>(rings[i] - 1);
        REQUIRE(elevation(beams[k]) == Approx(lowest[i] + spacing * static_cast<double>(k)).margin(1e-9));
        REQUIRE(std::abs(std::remainder(azimuth(beams[k]) + 360.0 * column / columns, 360)) < 1e-9);
        REQUIRE(later[k].direction == beams[k].direction);
      }
    }
  }
}

TEST_CASE("beams of every sensor are right-handed orthonormal frames, periods divide a tenth of a second") {
  for (const SensorKind kind : kKinds) {
    CAPTURE(facts(kind).name);
    const auto pattern = make_scan_pattern(kind);
    CHECK(kSecond / 10 % pattern->firing_period() == 0);
    std::vector<Beam> beams(pattern->beams_per_firing());
    for (int n = 0; n < 2000; ++n) {
      const TimeNs t = TimeNs{37} * n * pattern->firing_period();
      pattern->fire(t, beams);
      for (const Beam& b : beams) {
        REQUIRE(b.direction.norm() == Approx(1).epsilon(1e-12));
        REQUIRE((b.direction.cross(b.azimuth) - b.elevation).norm() < 1e-12);
        REQUIRE(std::abs(b.azimuth.z()) < 1e-12);
        REQUIRE(b.elevation.z() > 0);
      }
    }
  }
}

TEST_CASE("facts of the sensors are those of their data sheets") {
  CHECK(facts(SensorKind::avia).p_imu_lidar == Vec3(0.04165, 0.02326, -0.0284));
  CHECK(facts(SensorKind::mid360).p_imu_lidar == Vec3(-0.011, -0.02329, 0.04412));
  for (const SensorKind kind : kKinds) {
    const SensorFacts& f = facts(kind);
    CAPTURE(f.name);
    CHECK(f.range_noise == 0.02);
    CHECK(f.angle_noise > 1e-4);
    CHECK(f.angle_noise < 1e-3);
    CHECK(f.max_range > 50);
    CHECK(f.min_range <= 1);
    CHECK(f.lidar_topic != f.imu_topic);
  }
}

TEST_CASE("a VLP-16 fires as its manual says: 16 lasers one after the other, from different heights", "[lidar]") {
  const auto pattern = make_scan_pattern(SensorKind::vlp16);
  REQUIRE(pattern->beams_per_firing() == 16);
  CHECK(pattern->firing_period() == 55'296);
  CHECK(pattern->has_heights());
  std::vector<Beam> beams(16);
  for (const TimeNs t : {TimeNs{0}, 400 * pattern->firing_period(), 20'000 * pattern->firing_period()}) {
    pattern->fire(t, beams);
    for (std::size_t line = 0; line < 16; ++line) {
      CHECK(elevation(beams[line]) == Approx(-15.0 + 2.0 * static_cast<double>(line)).margin(1e-9));
      // Laser 0 is the lowest, laser 1 at 1 deg, laser 2 at -13 deg, ..; each fires 2.304 us after the one before.
      const std::size_t laser = line < 8 ? 2 * line : 2 * (line - 8) + 1;
      const double turned = 3600.0 * (1e-9 * static_cast<double>(t) + 2.304e-6 * static_cast<double>(laser));
      CHECK(std::remainder(azimuth(beams[line]) + turned, 360.0) == Approx(0).margin(1e-7));
    }
    CHECK(beams[0].height == Approx(0.0112));
    CHECK(beams[7].height == Approx(0.0007));
    CHECK(beams[8].height == Approx(-0.0007));
    CHECK(beams[15].height == Approx(-0.0112));
  }
}
