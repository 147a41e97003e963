#pragma once
/// When neighbours span neither a line nor a plane.

namespace aslio::plugins {

/// Neighbours closer together than this [m] are one point measured many times.
inline constexpr double kCoincident = 1e-6;

}  // namespace aslio::plugins
