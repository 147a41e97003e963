#pragma once

#include <array>
#include <cstdint>

#include "aslio/core/lie.hpp"
#include "aslio/core/time.hpp"
#include "aslio/simulator/scan_pattern.hpp"

namespace aslio::simulator {

/// The non-repetitive pattern of a Livox Avia: two prisms turn a stack of six beams (closed form of MARSIM's
/// simulator).
namespace avia {

inline constexpr int kLines = 6;
inline constexpr TimeNs kFiringPeriod = 25'000;  ///< [ns]; the six beams share one time: 240 000 points per second
inline constexpr double kFovHorizontal = 70.4, kFovVertical = 77.2;  ///< [deg]
inline constexpr double kLineSpacing = 1.4;                          ///< [deg]
inline constexpr double kPrism1 = 763.82589, kPrism2 = -488.41294;   ///< [rad/s]: 7294 and -4664 rpm

/// The six beams `t` seconds after the prisms stood in line, by line number.
std::array<Beam, kLines> firing(double t);

/// Azimuth and elevation of the middle of the stack (line 2) [rad].
struct Angles {
  double azimuth = 0, elevation = 0;
};
Angles angles(double t);

}  // namespace avia
}  // namespace aslio::simulator
