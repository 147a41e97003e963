#include "range_errors.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr double kNearRange = 2;                                           ///< distortion below this range [m]
constexpr double kLongestIncidence = 0.2;                                  ///< [m]
constexpr double kIncidenceRange = 10, kIncidenceAngle = 80 * kRadPerDeg;  ///< where `incidence` is given [m], [rad]

}  // namespace

RangeErrors::RangeErrors(const RangingRealism& ranging, std::uint64_t seed) : ranging_(ranging) {
  RandomStream random(seed, purpose::kRangeErrors);
  const auto up_to = [&](double bound) { return bound * random.uniform(-1, 1); };
  offset_ = up_to(ranging.offset);
  warm_up_ = up_to(ranging.warm_up);
  reflectivity_ = up_to(ranging.reflectivity);
  near_ = up_to(ranging.near);
  if (ranging.line > 0) std::generate(lines_.begin(), lines_.end(), [&] { return up_to(ranging.line); });
}

double RangeErrors::standing(std::size_t line, double t) const {
  const double warm = warm_up_ == 0 ? 0 : -warm_up_ * std::expm1(-t / kWarmUpTime);
  return offset_ + lines_[line % kLines] + warm;
}

// The near edge of an inclined footprint starts the echo: the range is too short by a part of the footprint's depth,
// which grows with range and with the tangent of the incidence.
double RangeErrors::of_echo(double range, double cos_incidence, double reflectivity) const {
  double error = reflectivity_ * (1 - reflectivity);
  if (range < kNearRange) error += near_ * (1 - range / kNearRange) * (1 - range / kNearRange);
  if (ranging_.incidence > 0) {
    const double sine = std::sqrt(std::max(0.0, 1 - cos_incidence * cos_incidence));
    const double tangent = sine / std::max(cos_incidence, 1e-3);
    const double depth = ranging_.incidence * range / kIncidenceRange * tangent / std::tan(kIncidenceAngle);
    error -= std::min(depth, kLongestIncidence);
  }
  return error;
}

double RangeErrors::noise(double range, double reach) const {
  const double share = std::min(1.0, range / std::max(reach, 1e-9));
  return 1 + ranging_.noise_growth * share * share;
}

}  // namespace aslio::simulator
