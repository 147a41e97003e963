#pragma once
/// The motion over a window whose IMU readings cannot be believed, found by its points (docs/equations.md WID-1).

#include <deque>
#include <span>
#include <vector>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"
#include "motion_normal.hpp"

namespace aslio::pipeline {

/// Where the IMU says nothing for some time, or its gyro is stuck, dead or at the end of its range, a prediction may be
/// off by more than the matches of an estimator bear. Then the points of the window are registered with those of the
/// last seconds, coarse to fine, and readings that agree with what they say stand in for the missing ones: the same for
/// all estimators. Windows with readings that are believed cost nothing but the keeping of some points. Same input,
/// same bits.
class WideMotion {
 public:
  static constexpr TimeNs kLongGap = kSecond / 10;  ///< of the IMU: what a line between two readings bridges

  explicit WideMotion(const SensorModel& sensor) : sensor_(sensor) {}

  void forget() { seen_.clear(); }
  /// Keeps some points of an update, where it placed them.
  void observe(const Window& window, const Update& update);
  /// Replaces window.imu when it cannot be believed and the points bind the motion better; the new ones are here until
  /// the next call. `at`: the state at the begin of the window; `rate`: of turning, by the last updates [rad/s], in I.
  /// Returns whether it did.
  bool mend(Window& window, const NavState& at, const Vec3& rate);

 private:
  struct Seen {
    TimeNs t;
    Vec3 p_W;
  };
  /// Readings, and how well the points agree when they are placed by them.
  struct Guess {
    std::vector<ImuSample> imu;
    double fit = 0;
  };

  static bool doubtful(const Window& window);
  void load_reference(const NavState& at);
  std::vector<SweepPoint> load_points(const Window& window, const NavState& at, std::span<const ImuSample> imu) const;
  void build(const ConstantMotion& known, const RegistrationLevel& level);
  double fit(const Window& window, const NavState& at, const Guess& guess);
  void refine(const Window& window, const NavState& at, Guess& guess);

  SensorModel sensor_;
  std::deque<Seen> seen_;
  std::vector<SweepPoint> reference_;
  SweepCells cells_;
  std::vector<ImuSample> imu_;
};

}  // namespace aslio::pipeline
