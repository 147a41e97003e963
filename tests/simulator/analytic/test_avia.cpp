#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/simulator/avia.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr double kCell = 0.5;  ///< [deg]
constexpr int kColumns = 142, kRows = 156;

bool in_ellipse(double azimuth, double elevation) {
  const double a = azimuth / (avia::kFovHorizontal / 2), e = elevation / (avia::kFovVertical / 2);
  return a * a + e * e <= 1;
}

/// Share of the cells with their middle in the field of view that receive a beam within `duration` [s].
double coverage(double begin, double duration) {
  std::vector<char> seen(static_cast<std::size_t>(kColumns * kRows), 0);
  const double period = to_seconds(avia::kFiringPeriod);
  for (double t = begin; t < begin + duration; t += period)
    for (const Beam& beam : avia::firing(t)) {
      const double azimuth = std::atan2(beam.direction.y(), beam.direction.x()) / kDeg;
      const double elevation = std::asin(beam.direction.z()) / kDeg;
      const int column = static_cast<int>(std::floor(azimuth / kCell)) + kColumns / 2;
      const int row = static_cast<int>(std::floor(elevation / kCell)) + kRows / 2;
      if (column >= 0 && column < kColumns && row >= 0 && row < kRows)
        seen[static_cast<std::size_t>(row * kColumns + column)] = 1;
    }
  int cells = 0, hit = 0;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      if (!in_ellipse((column - kColumns / 2 + 0.5) * kCell, (row - kRows / 2 + 0.5) * kCell)) continue;
      ++cells;
      hit += seen[static_cast<std::size_t>(row * kColumns + column)];
    }
  return static_cast<double>(hit) / cells;
}

double mean_coverage(double duration) {
  double sum = 0;
  for (int i = 0; i < 10; ++i) sum += coverage(0.37 * i, duration);
  return 10 * sum;
}

}  // namespace

TEST_CASE("coverage of the field of view grows as tabulated for the pattern") {
  CHECK(std::abs(mean_coverage(0.008) - 7.8) < 3);
  CHECK(std::abs(mean_coverage(0.020) - 16.9) < 3);
  CHECK(std::abs(mean_coverage(0.050) - 35.6) < 3);
  CHECK(std::abs(mean_coverage(0.100) - 57.7) < 3);
  CHECK(std::abs(mean_coverage(0.200) - 80.9) < 3);
}

TEST_CASE("beams are orthonormal frames within the field of view, lines 1.4 deg apart") {
  double widest = 0, highest = 0;
  for (int n = 0; n < 40'000; ++n) {
    const auto beams = avia::firing(n * 25e-6);
    const avia::Angles middle = avia::angles(n * 25e-6);
    for (std::size_t line = 0; line < beams.size(); ++line) {
      const Beam& b = beams[line];
      const double azimuth = std::atan2(b.direction.y(), b.direction.x()), elevation = std::asin(b.direction.z());
      widest = std::max(widest, std::abs(azimuth));
      highest = std::max(highest, std::abs(elevation));
      if (n % 100 != 0) continue;
      CHECK(azimuth == Approx(middle.azimuth).margin(1e-12));
      CHECK(elevation == Approx(middle.elevation + (static_cast<double>(line) - 2) * 1.4 * kDeg).margin(1e-12));
      Mat3 frame;
      frame << b.direction, b.azimuth, b.elevation;
      CHECK((frame.transpose() * frame - Mat3::Identity()).norm() < 1e-12);
      CHECK(frame.determinant() > 0);
    }
  }
  CHECK(widest <= avia::kFovHorizontal / 2 * kDeg);
  CHECK(highest <= avia::kFovVertical / 2 * kDeg);
  CHECK(widest > 0.9 * avia::kFovHorizontal / 2 * kDeg);
  CHECK(highest > 0.9 * avia::kFovVertical / 2 * kDeg);
}
