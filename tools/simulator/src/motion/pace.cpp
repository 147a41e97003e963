#include "pace.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bisection.hpp"

namespace aslio::simulator {
namespace {

// Per m/s of the speed on straight lines: from rest to there in 1.56 s, whatever that speed is.
constexpr double kAcceleration = 1.2;  ///< [1/s]
constexpr double kJerk = 6;            ///< [1/s^2]

}  // namespace

double Pace::time(double from, double to) const {
  // The step's first and second derivatives peak at 15/8 and 10/sqrt(3).
  const double change = std::abs(to - from) / speed_;
  return std::max(1.875 * change / kAcceleration, std::sqrt(10 / std::numbers::sqrt3 * change / kJerk));
}

double Pace::distance(double from, double to) const { return 0.5 * (from + to) * time(from, to); }

double Pace::reachable(double from, double length, double limit) const {
  if (limit <= from) return limit;
  return highest(from, limit, [&](double v) { return distance(from, v) <= length; });
}

double Pace::peak(double from, double to, double length) const {
  const double low = std::max(from, to);
  return highest(low, std::max(low, speed_), [&](double v) { return distance(from, v) + distance(v, to) <= length; });
}

}  // namespace aslio::simulator
