#pragma once
/// Time is int64 nanoseconds in one clock, the clock of the data. Doubles appear only as differences
/// (seconds relative to a nearby epoch), because a double holds an absolute epoch to 240 ns at best.

#include <cmath>
#include <cstdint>
#include <limits>

namespace aslio {

using TimeNs = std::int64_t;

inline constexpr TimeNs kTimeMin = std::numeric_limits<TimeNs>::min();
inline constexpr TimeNs kTimeMax = std::numeric_limits<TimeNs>::max();
inline constexpr TimeNs kSecond = 1'000'000'000;

/// Duration in seconds. Exact to 1 ns for durations below 50 days.
constexpr double to_seconds(TimeNs duration) { return 1e-9 * static_cast<double>(duration); }

/// Duration in nanoseconds, rounded to nearest.
inline TimeNs to_ns(double seconds) { return static_cast<TimeNs>(std::llround(seconds * 1e9)); }

}  // namespace aslio
