#pragma once
/// A motion that changes smoothly, for the tests of the fixed-lag smoother.

#include <cmath>

#include "estimators/lag_window.hpp"

namespace aslio::test {

using plugins::InertialNoise;
using plugins::InertialTerm;
using plugins::kNodeDim;
using plugins::LagWindow;
using plugins::Mat15;
using plugins::moved;
using plugins::PoseTerm;
using plugins::Preintegration;
using plugins::PriorTerm;
using plugins::StateTerm;
using plugins::Vec15;

/// Rates and forces that change smoothly.
inline ImuSample smooth_sample(double seconds) {
  ImuSample s;
  s.t = to_ns(seconds);
  s.gyro = Vec3(std::sin(3 * seconds), 0.8 * std::cos(2 * seconds), 0.5 + 0.3 * seconds);
  s.acc = Vec3(1.0 + std::sin(4 * seconds), -0.5 * std::cos(3 * seconds), 9.8 + 0.4 * std::sin(seconds));
  return s;
}

/// What is known of an IMU with these biases.
inline NavState biased(const Vec3& b_w, const Vec3& b_a) {
  NavState known;
  known.b_w = b_w;
  known.b_a = b_a;
  return known;
}

/// Where the motion leads from `from`.
inline NavState carried(const NavState& from, const Preintegration& m) {
  NavState to = from;
  to.R = from.R * m.dR;
  to.v = from.v + m.seconds * from.g + from.R * m.dv;
  to.p = from.p + m.seconds * from.v + 0.5 * m.seconds * m.seconds * from.g + from.R * m.dp;
  return to;
}

/// How well the first state is known.
inline Vec15 start_sigma() {
  Vec15 sigma;
  sigma << Vec3::Constant(0.01), Vec3::Constant(0.01), Vec3::Constant(0.5), Vec3::Constant(0.05), Vec3::Constant(0.3);
  return sigma;
}

}  // namespace aslio::test
