#include "aslio/simulator/avia.hpp"

#include <cmath>

#include "aslio/core/angles.hpp"

namespace aslio::simulator::avia {
namespace {

/// Amplitudes of each prism: fractions of the full field of view.
constexpr double kAzimuth = 0.48 * kFovHorizontal / 2 * kRadPerDeg;
constexpr double kElevation = 0.43 * kFovVertical / 2 * kRadPerDeg;
/// Line 2 is the middle: the offsets are -2, -1, 0, 1, 2, 3 spacings.
constexpr int kMiddleLine = 2;

}  // namespace

Angles angles(double t) {
  return {kAzimuth * (std::cos(kPrism1 * t) + std::cos(kPrism2 * t)),
          kElevation * (std::sin(kPrism1 * t) + std::sin(kPrism2 * t))};
}

std::array<Beam, kLines> firing(double t) {
  const Angles middle = angles(t);
  const double ca = std::cos(middle.azimuth), sa = std::sin(middle.azimuth);
  std::array<Beam, kLines> beams;
  for (int line = 0; line < kLines; ++line) {
    const double elevation = middle.elevation + (line - kMiddleLine) * kLineSpacing * kRadPerDeg;
    const double ce = std::cos(elevation), se = std::sin(elevation);
    Beam& beam = beams[static_cast<std::size_t>(line)];
    beam.direction << ce * ca, ce * sa, se;
    beam.azimuth << -sa, ca, 0;
    beam.elevation << -se * ca, -se * sa, ce;
  }
  return beams;
}

}  // namespace aslio::simulator::avia
