#pragma once

#include <span>
#include <vector>

#include "aslio/stages/motion.hpp"
#include "aslio/toolkit/window_trajectory.hpp"

namespace aslio::plugins {

/// The motion inside a window as the IMU measured it: its poses, and the state at every sample.
class WindowPath {
 public:
  explicit WindowPath(WindowTrajectory::Spread spread);

  /// An empty path from `begin` on. `imu` stays valid until the next start.
  void start(const NavState& begin, std::span<const ImuSample> imu);
  /// Goes on with the segment that ends in `state`.
  void append(const MotionSegment& segment, const NavState& state);
  /// Once nothing is left to append: without a sample inside, `end` is the one state.
  void close(const NavState& end);
  /// The path that ends in `end` when `motion` reads the samples with the biases and the calibration of `end`: its
  /// begin turns and moves (docs/equations.md DSK-3).
  void repropagate(const MotionModel& motion, const NavState& end);

  const NavState& begin() const { return begin_; }
  std::span<const ImuSample> imu() const { return imu_; }
  WindowTrajectory& trajectory() { return trajectory_; }
  const WindowTrajectory& trajectory() const { return trajectory_; }
  /// At every sample but the first; never empty after close().
  std::vector<NavState>& states() { return states_; }

 private:
  NavState begin_;
  std::span<const ImuSample> imu_;
  WindowTrajectory trajectory_;
  std::vector<NavState> states_;
};

}  // namespace aslio::plugins
