#include "aslio/pipeline/new_start.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "aslio/core/angles.hpp"
#include "imu_at_start.hpp"
#include "imu_gap.hpp"

namespace aslio::pipeline {

namespace {

/// A position that was dead-reckoned for longer is worth less than none [s].
constexpr double kReckonedPosition = 10.0;
/// An acceleration turns the mean specific force by no more than this from the vertical [rad].
constexpr double kMaxTilt = 20.0 * kRadPerDeg;

/// A sensor that is dead-reckoned to be faster than this after `blind` [s] is not at rest, however quiet its IMU: it
/// may go at an even speed [m/s].
double fastest_at_rest(double blind) { return 0.4 + 0.05 * blind; }

bool agree_on_vertical(const NavState& reckoned, const Vec3& acc) {
  const Vec3 up = -(reckoned.R.transpose() * reckoned.g);
  return up.normalized().dot(acc.normalized()) > std::cos(kMaxTilt);
}

/// Everything but what is doubted more with time.
void recall(InitialState& start, const NavState& reckoned, double blind) {
  const TimeNs t = start.state.t;
  const Vec3 p = start.state.p;
  start.state = reckoned;
  start.state.t = t;
  start.state.p = p;
  start.sigma_velocity = std::min(start.sigma_velocity, 0.3 + 0.1 * blind);
  start.sigma_tilt = std::min(start.sigma_tilt, (1.0 + 0.1 * blind) * kRadPerDeg);
  start.sigma_gyro_bias = std::min(start.sigma_gyro_bias, 0.005);
}

}  // namespace

TimeNs NewStart::keep_imu_from() const {
  return known_.state && from_ - known_.state->t <= kLongestReckoning ? known_.state->t : from_ - 1;
}

std::optional<NavState> NewStart::reckoned(const stream::MeasurementStream& stream, const Estimator& estimator,
                                           TimeNs t) const {
  std::vector<ImuSample> imu;
  if (!known_.state || t - known_.state->t > kLongestReckoning) return std::nullopt;
  stream.imu_covering(known_.state->t, t, imu);
  if (!can_be_reckoned(imu)) return std::nullopt;
  const NavState state = estimator.predict(imu);
  const bool finite = state.R.allFinite() && state.p.allFinite() && state.v.allFinite();
  return finite && state.v.norm() <= known_.max_speed ? std::optional(state) : std::nullopt;
}

// eq. INI-5.
std::optional<Initialisation> NewStart::find(const stream::MeasurementStream& stream, const Estimator& estimator) {
  if (!estimator.uses_imu()) {
    const auto points = stream.points(from_, stream.points_until());
    if (points.empty()) return std::nullopt;
    Initialisation out = start_without_imu(points.front().t - 1);
    out.initial.state.R = known_.pose.R;
    out.initial.state.p = known_.pose.p;
    return out;
  }
  while (true) {
    const auto after = stream.imu(from_ - 1, stream.imu_until());
    if (after.empty()) return std::nullopt;
    const TimeNs begin = after.front().t;
    const auto used = samples_over(stream, begin, stream.imu_until(), params_.time, begin);
    if (used.empty()) return std::nullopt;
    const auto gap = std::adjacent_find(used.begin(), used.end(), is_gap);
    if (gap != used.end()) {  // what was measured before it says nothing of after
      from_ = std::next(gap)->t;
      continue;
    }
    const auto dead = std::find_if(used.begin(), used.end(), [](const ImuSample& s) {
      return (s.faults & (imu_fault::gyro_dead | imu_fault::acc_dead)) != 0;
    });
    if (dead != used.end()) {
      from_ = dead->t + 1;
      continue;
    }
    from_ = used.back().t;
    const Averages mean = average(used);
    // That the recording starts at rest says nothing of later.
    const bool quiet = params_.mode != InitialisationMode::dynamic_start && is_at_rest(mean, params_);
    if (!may_be_gravity(mean.acc.norm(), quiet)) continue;

    const auto known = reckoned(stream, estimator, from_);
    const double blind = to_seconds(from_ - known_.accepted);
    const bool at_rest = quiet && known && known->v.norm() < fastest_at_rest(blind);
    Initialisation out = start_of(used, mean, at_rest, sensor_);
    InitialState& start = out.initial;
    const Mat3& R = known ? known->R : known_.pose.R;
    start.state.R = to_vertical(R * mean.acc) * R;  // the heading that was known, the vertical of now
    start.state.p = known && blind <= kReckonedPosition ? known->p : known_.pose.p;
    if (at_rest) {
      start.sigma_velocity = std::max(start.sigma_velocity, known->v.norm());
    } else if (known && agree_on_vertical(*known, mean.acc)) {
      recall(start, *known, blind);
    }
    return out;
  }
}

}  // namespace aslio::pipeline
