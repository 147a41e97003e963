#include "bias_watch.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::pipeline {

namespace {

constexpr double kNowTime = 0.3, kUsualTime = 5.0, kLearning = 2.0;  // [s]
constexpr double kStepFactor = 5.0;                                  // times what is usual
constexpr double kMinStep = 0.002;                                   // [rad/s]: a part that warms up changes by less
constexpr double kStepFor = 0.2;                                     // [s]
constexpr double kFastTurn = 0.5;  // [rad/s]: then scale, cross-axis terms and delays turn predictions, too

bool says_nothing(const Window& window, const Update& update) {
  if (!update.accepted || update.unobservable_direction() || window.imu_gap > 0 || window.imu.size() < 2) return true;
  double fastest = 0;
  std::uint8_t faults = 0;
  for (const ImuSample& s : window.imu) {
    fastest = std::max(fastest, s.gyro.norm());
    faults |= s.faults;
  }
  return faults != 0 || fastest > kFastTurn;
}

}  // namespace

// eq. MOT-13.
double BiasWatch::observe(const Window& window, const Update& update) {
  if (says_nothing(window, update)) return 0;
  const double dt = std::clamp(to_seconds(window.plan.end - window.plan.fresh_begin), 1e-3, 0.5);
  const Vec3 pull = log_so3(update.prior.R.transpose() * update.state.R) / dt;
  now_ += (1 - std::exp(-dt / kNowTime)) * (pull - now_);
  seen_ += dt;
  const double square = now_.squaredNorm();
  const bool steps = seen_ > kLearning && square > kMinStep * kMinStep && square > kStepFactor * kStepFactor * usual_;
  steps_for_ = steps ? steps_for_ + dt : 0;
  if (steps_for_ > kStepFor) {
    begin();
    return std::sqrt(square);
  }
  const double share = 1 - std::exp(-dt / std::min(kUsualTime, std::max(seen_, dt)));
  if (!steps) usual_ += share * (square - usual_);
  return 0;
}

}  // namespace aslio::pipeline
