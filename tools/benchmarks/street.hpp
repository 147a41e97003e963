#pragma once
/// A street to drive along, for timings and bounds of what keeps its cells.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "aslio/stages/points.hpp"

namespace aslio::benchmarks {

/// 64 beams at 375 azimuths from (x, 0, 1.8) in a street 20 m wide with a house corner every 15 m.
inline std::vector<WorldPoint> sweep(std::mt19937_64& engine, double x) {
  // The same numbers everywhere (std distributions are not).
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::vector<WorldPoint> points;
  for (int step = 0; step < 375; ++step) {
    for (int beam = 0; beam < 64; ++beam) {
      const double elevation = (-25.0 + 0.6 * beam) * 0.01745, azimuth = 6.2832 * (step + uniform()) / 375.0;
      const Vec3 ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation));
      double range = ray.z() < 0 ? -1.8 / ray.z() : 80.0;
      double wall = 10.0 / std::max(1e-3, std::abs(ray.y()));
      const double along = x + wall * ray.x();
      if (std::fmod(std::abs(along), 15.0) < 5.0) wall *= 1.3;  // set back
      range = std::min({range, wall, 80.0}) + 0.02 * (uniform() + uniform() - 1.0);
      WorldPoint point;
      point.p_W = Vec3(x, 0, 1.8) + range * ray;
      point.range = static_cast<float>(range);
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace aslio::benchmarks
