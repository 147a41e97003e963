#pragma once
/// Systematic errors of a LiDAR's ranges.

#include <array>
#include <cstddef>
#include <cstdint>

#include "aslio/simulator/realism.hpp"

namespace aslio::simulator {

/// What one sensor has from birth, drawn by the seed. Every effect has a fixed place in the stream.
class RangeErrors {
 public:
  RangeErrors(const RangingRealism& ranging, std::uint64_t seed);

  static constexpr std::size_t kLines = 256;  ///< lines beyond have the errors of the first ones

  /// Error of every range of a line, `t` seconds after the sensor was switched on [m].
  double standing(std::size_t line, double t) const;
  /// Error that depends on the echo [m]: `range` [m], cosine of the incidence in [0, 1], `reflectivity` in [0, 1].
  double of_echo(double range, double cos_incidence, double reflectivity) const;
  /// Factor of the range noise of an echo from `range`, where the farthest echo of its strength is from `reach` [m].
  double noise(double range, double reach) const;

 private:
  RangingRealism ranging_;
  std::array<double, kLines> lines_{};
  double offset_ = 0, warm_up_ = 0, reflectivity_ = 0, near_ = 0;  ///< of this sensor [m]
};

}  // namespace aslio::simulator
