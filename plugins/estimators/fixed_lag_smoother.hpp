#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/estimator.hpp"
#include "estimators/lag_window.hpp"

namespace aslio::plugins {

/// A registration with a smoother behind it (LIO-SAM, Shan et al., IROS 2020): `front` finds the pose of each window
/// from where the IMU takes the last state; its poses and what the IMU says between them are smoothed over the last
/// states, and give velocity and biases (docs/equations.md LAG-1 to LAG-3), from which the front goes on. The pose is
/// that of the front. Allocates.
class FixedLagSmoother final : public Estimator {
 public:
  struct Params {
    LagWindow::Params window;
    double max_speed = 30.0;
    double max_bias = 1.0;
    config::Nested<MotionModel> motion{"imu_midpoint"};
    config::Nested<Estimator> front{"scan_matcher"};
  };
  static void describe(config::Binder& b, Params& p);
  /// Throws ConfigError when the front takes no IMU data, or smooths by itself.
  FixedLagSmoother(const Params& params, const BuildContext& context);

  MapContent map_content() const override { return front_->map_content(); }
  bool uses_history() const override { return front_->uses_history(); }
  bool uses_cuts() const override { return front_->uses_cuts(); }
  bool uses_features() const override { return front_->uses_features(); }
  bool smooths() const override { return true; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override;
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  void smooth(const Preintegration& motion, const Update& found);
  void start_window(const NavState& state, double sigma_velocity);
  bool plausible(const NavState& state) const;

  Params params_;
  std::unique_ptr<MotionModel> motion_;
  std::unique_ptr<Estimator> front_;
  LagWindow window_;
  InitialState initial_;
  NavState state_;
  Update result_;
};

}  // namespace aslio::plugins
