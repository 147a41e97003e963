#pragma once

#include <cstdint>

/// One random stream each.
namespace aslio::simulator::purpose {

inline constexpr std::uint64_t kInitialBias = 1, kBiasWalk = 2, kGyroNoise = 3, kAccNoise = 4, kImuCalibration = 5;
inline constexpr std::uint64_t kRange = 10, kAngle = 11, kDropout = 12, kOutlier = 13, kMixedPixel = 14;
inline constexpr std::uint64_t kGlass = 15, kRangeErrors = 16;
inline constexpr std::uint64_t kTurnTimes = 20, kGaitPhase = 21, kPeople = 22, kRoad = 23, kCars = 24, kSway = 25,
                               kLean = 26;
inline constexpr std::uint64_t kStampJitter = 30, kPacketLoss = 31, kImuLoss = 32, kExtrinsicError = 33,
                               kMountRealism = 34, kClock = 35, kTemperature = 36, kVibration = 37;
/// Worlds draw their layout and clutter from (seed of the world, kLayout, part).
inline constexpr std::uint64_t kLayout = 40;

}  // namespace aslio::simulator::purpose
