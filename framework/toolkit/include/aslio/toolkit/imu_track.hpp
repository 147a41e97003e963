#pragma once
/// The IMU beside a registration: it predicts, and learns velocity, biases and gravity from the poses that were found.

#include "aslio/stages/estimator.hpp"
#include "aslio/toolkit/imu_noise.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "aslio/toolkit/window_trajectory.hpp"

namespace aslio {

class ImuTrack {
 public:
  struct Params {
    ImuNoisePreset noise;
    config::Nested<MotionModel> motion{"imu_midpoint"};
  };
  ImuTrack(const Params& params, const BuildContext& context);

  void reset(const InitialState& initial);
  NavState predict(const NavState& from, std::span<const ImuSample> imu) const;
  /// The state at the end of the window; P() follows, but for a window over which it would not stay finite. Every
  /// interval is appended to `path`, if there is one.
  NavState propagate(const NavState& from, const Window& window, WindowTrajectory* path = nullptr);
  /// The prediction after a registration found `pose` for it, known with `information` of (theta, p): one update of a
  /// Kalman filter that measures the pose (eqs. IESKF-4 to IESKF-6, H = I). P() follows.
  NavState correct(const NavState& predicted, const Pose& pose, const Mat6& information);
  const StateMatrix& P() const { return P_; }

 private:
  Params params_;
  SensorModel sensor_;
  std::unique_ptr<MotionModel> motion_;
  EstimatedStates estimated_;
  UnresolvedMotion unresolved_;
  StateMatrix P_ = StateMatrix::Zero();
};

}  // namespace aslio
