#include "doubted_imu.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::pipeline {

void DoubtedImu::observe(const NavState& state) {
  if (state.R.allFinite()) attitudes_[count_++ % attitudes_.size()] = {state.t, state.R};
}

Vec3 DoubtedImu::rate() const {
  constexpr TimeNs kShortest = 40'000'000;  // shorter windows know their rate less well than it changes
  const std::size_t n = std::min(count_, attitudes_.size());
  if (n < 2) return Vec3::Zero();
  std::size_t from = 1;
  while (from + 1 < n && back(0).t - back(from).t < kShortest) ++from;
  const TimeNs dt = back(0).t - back(from).t;
  if (dt <= 0 || dt > kSecond) return Vec3::Zero();
  return log_so3(back(from).R.transpose() * back(0).R) / to_seconds(dt);
}

void DoubtedImu::mend(Window& window, const NavState& at) {
  if (std::none_of(window.imu.begin(), window.imu.end(), [](const ImuSample& s) { return s.faults != 0; })) return;
  imu_.assign(window.imu.begin(), window.imu.end());
  const Vec3 w = rate();
  const Vec3 expected = w + at.S_w * w + at.b_w;
  Mat3 R = at.R;
  for (std::size_t i = 0; i < imu_.size(); ++i) {
    ImuSample& s = imu_[i];
    for (int axis = 0; axis < 3; ++axis) {
      if ((s.faults & imu_fault::gyro_dead) != 0) {
        s.gyro[axis] = expected[axis];
      } else if ((s.faults & imu_fault::clipped(false, axis)) != 0 && s.gyro[axis] * expected[axis] > 0) {
        s.gyro[axis] = std::copysign(std::max(std::abs(s.gyro[axis]), std::abs(expected[axis])), s.gyro[axis]);
      }
    }
    if (i > 0) R = R * exp_so3(to_seconds(s.t - imu_[i - 1].t) * (0.5 * (imu_[i - 1].gyro + s.gyro) - at.b_w));
    if ((s.faults & imu_fault::acc_dead) != 0) s.acc = at.b_a - R.transpose() * at.g;  // no acceleration in W
  }
  window.imu = imu_;
}

}  // namespace aslio::pipeline
