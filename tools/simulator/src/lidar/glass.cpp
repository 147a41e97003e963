#include "lidar/glass.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::simulator {
namespace {

constexpr double kIndex = 1.52;

}  // namespace

double mirrored_share(double cos_incidence) {
  const double c = std::clamp(cos_incidence, 0.0, 1.0);
  const double inside = std::sqrt(1 - (1 - c * c) / (kIndex * kIndex));
  const double s = (c - kIndex * inside) / (c + kIndex * inside), p = (kIndex * c - inside) / (kIndex * c + inside);
  const double one = 0.5 * (s * s + p * p);
  // Two surfaces with all echoes between them.
  return 2 * one / (1 + one);
}

PaneEffect pane_effect(double draw, double clear, double cos_incidence) {
  if (draw >= clear) return PaneEffect::returned;
  return draw < clear * mirrored_share(cos_incidence) ? PaneEffect::mirrored : PaneEffect::passed;
}

}  // namespace aslio::simulator
