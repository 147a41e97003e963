#pragma once
/// What stands in for IMU readings that are not believed, the same for all estimators (docs/equations.md MOT-12).

#include <array>
#include <cstddef>
#include <vector>

#include "aslio/stages/window.hpp"

namespace aslio::pipeline {

/// Dead sensors are replaced by a motion of constant velocity and constant rate, as the last updates found it; an axis
/// of the gyro that is clipped turns at least as fast as it reads, and as the last updates found. The faults stay
/// marked: estimators know that these are no readings.
class DoubtedImu {
 public:
  void begin(const NavState& state) {
    count_ = 0;
    observe(state);
  }
  /// The state at the end of every update.
  void observe(const NavState& state);
  /// Replaces what is marked in the window's IMU data, which then are here until the next call. `at`: the state at the
  /// begin of the window.
  void mend(Window& window, const NavState& at);
  /// Of turning, over the last 40 ms of updates at least [rad/s], in I.
  Vec3 rate() const;

 private:
  struct Attitude {
    TimeNs t = 0;
    Mat3 R = Mat3::Identity();
  };
  const Attitude& back(std::size_t n) const { return attitudes_[(count_ - 1 - n) % attitudes_.size()]; }

  std::array<Attitude, 16> attitudes_{};  ///< a ring
  std::size_t count_ = 0;
  std::vector<ImuSample> imu_;
};

}  // namespace aslio::pipeline
