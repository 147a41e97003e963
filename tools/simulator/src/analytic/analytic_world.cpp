#include "aslio/simulator/analytic_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "home.hpp"

namespace aslio::simulator {
namespace {

constexpr double kTruthRate = 200;

double checked(double value, double low, double high, const char* name) {
  if (value >= low && value <= high) return value;
  throw ConfigError(fmt::format("{} is {}, must be in [{}, {}]", name, value, low, high));
}

SensorModel avia_sensor() {
  SensorModel sensor;
  sensor.T_imu_lidar.p = Vec3(0.04165, 0.02326, -0.0284);
  return sensor;
}

ImuModel imu_model(const Options& options) {
  ImuModel model;
  model.rate = checked(options.imu_rate, 20, 10000, "imu_rate");
  return model;
}

}  // namespace

AnalyticWorld::AnalyticWorld(const Options& options)
    : options_(options),
      sensor_(avia_sensor()),
      scene_(home::solids()),
      motion_(home::walk(checked(options.duration_scale, 0.5, 100, "duration_scale"))),
      imu_(simulate_imu(motion_, options.begin, home::kDuration * options.duration_scale, imu_model(options), sensor_,
                        options.imu_noise, options.seed)) {}

TimeNs AnalyticWorld::end_time() const { return options_.begin + to_ns(home::kDuration * options_.duration_scale); }

MotionState AnalyticWorld::motion(TimeNs t) const { return motion_.at(to_seconds(t - options_.begin)); }

Pose AnalyticWorld::pose(TimeNs t) const {
  const MotionState m = motion(t);
  return {m.R, m.p};
}

NavState AnalyticWorld::state(TimeNs t) const {
  const MotionState m = motion(t);
  const auto later = [](TimeNs limit, const ImuSample& s) { return limit < s.t; };
  const auto next = std::upper_bound(imu_.samples.begin(), imu_.samples.end(), t, later);
  const auto at = static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - imu_.samples.begin() - 1, 0));
  NavState state;
  state.t = t;
  state.R = m.R;
  state.p = m.p;
  state.v = m.v;
  state.b_w = imu_.gyro_bias[at];
  state.b_a = imu_.acc_bias[at];
  return state;
}

Trajectory AnalyticWorld::truth() const {
  std::vector<StampedPose> poses;
  const auto count = std::llround(to_seconds(end_time() - begin_time()) * kTruthRate);
  for (long long k = 0; k <= count; ++k) {
    const TimeNs t = begin_time() + to_ns(static_cast<double>(k) / kTruthRate);
    poses.push_back({t, pose(t)});
  }
  return Trajectory(std::move(poses));
}

std::vector<Box> AnalyticWorld::people(TimeNs t) const {
  if (!options_.people) return {};
  return home::people(to_seconds(t - options_.begin));
}

}  // namespace aslio::simulator
