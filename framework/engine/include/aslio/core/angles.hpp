#pragma once
/// Degrees, in which people write angles, and radians, in which everything here is computed.

#include <numbers>

namespace aslio {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace aslio
