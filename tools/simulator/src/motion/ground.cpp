#include "aslio/simulator/ground.hpp"

#include <cmath>

#include "jet.hpp"

namespace aslio::simulator {
namespace {

/// Adds a function of c x + s y, given its value and its derivatives along that line.
void add(GroundHeight& sum, double c, double s, const Jet& f) {
  sum.z += f.x;
  sum.zx += c * f.d;
  sum.zy += s * f.d;
  sum.zxx += c * c * f.dd;
  sum.zxy += c * s * f.dd;
  sum.zyy += s * s * f.dd;
}

}  // namespace

GroundHeight Ground::at(double x, double y) const {
  GroundHeight sum;
  for (const Wave& wave : waves) {
    const double phase = wave.kx * x + wave.ky * y + wave.phase;
    const double height = wave.amplitude * std::sin(phase);
    add(sum, wave.kx, wave.ky, {height, wave.amplitude * std::cos(phase), -height});
  }
  for (const Ramp& ramp : ramps) {
    const double c = std::cos(ramp.heading), s = std::sin(ramp.heading);
    const Jet along{c * x + s * y, 1, 0};
    add(sum, c, s, ramp.rise * smooth_step(unit_time(along, ramp.begin, ramp.length)));
  }
  return sum;
}

}  // namespace aslio::simulator
