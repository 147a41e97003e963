#include "estimators/window_path.hpp"

#include "aslio/core/lie.hpp"

namespace aslio::plugins {

WindowPath::WindowPath(WindowTrajectory::Spread spread) : trajectory_(spread) {
  constexpr std::size_t kImuSamples = 256;  // of a window without a gap, at any usual rate
  trajectory_.reserve(kImuSamples);
  states_.reserve(kImuSamples);
}

void WindowPath::start(const NavState& begin, std::span<const ImuSample> imu) {
  begin_ = begin;
  imu_ = imu;
  trajectory_.clear(begin);
  states_.clear();
}

void WindowPath::append(const MotionSegment& segment, const NavState& state) {
  trajectory_.append(segment, state);
  states_.push_back(state);
}

void WindowPath::close(const NavState& end) {
  if (states_.empty()) states_.push_back(end);
}

void WindowPath::repropagate(const MotionModel& motion, const NavState& end) {
  NavState start = begin_;
  start.b_w = end.b_w;
  start.b_a = end.b_a;
  start.g = end.g;
  start.S_w = end.S_w;
  start.imu_delay = end.imu_delay;
  NavState last = start;
  for (std::size_t i = 1; i < imu_.size(); ++i) motion.step(last, imu_[i - 1], imu_[i]);
  // Turned by Q as a whole, all velocities but those from gravity turn with it.
  const Mat3 Q = end.R * last.R.transpose();
  const Vec3 fallen = to_seconds(last.t - start.t) * end.g;
  start.R = orthonormalised(Q * start.R);
  start.v = end.v - Q * (last.v - start.v - fallen) - fallen;
  NavState state = start;
  trajectory_.clear(start);
  states_.clear();
  for (std::size_t i = 1; i < imu_.size(); ++i) {
    const MotionSegment segment = motion.step(state, imu_[i - 1], imu_[i]);
    append(segment, state);
  }
  const Vec3 by = end.p - state.p;
  trajectory_.shift(by);
  for (NavState& inside : states_) inside.p += by;
  close(end);
}

}  // namespace aslio::plugins
