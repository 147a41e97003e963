#pragma once

#include <cstdint>

/// One random stream each.
namespace aslio::simulator::purpose {

inline constexpr std::uint64_t kInitialBias = 1, kBiasWalk = 2, kGyroNoise = 3, kAccNoise = 4;
inline constexpr std::uint64_t kRange = 10, kAngle = 11, kDropout = 12;

}  // namespace aslio::simulator::purpose
