#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/toolkit/registration.hpp"

namespace my_plugin {

/// What is the state, given window and map? Here: registration. The gyro says how far the window turns, the velocity of
/// the last one how far it goes. Gauss-Newton steps, each with new matches, move its end until they are small, and the
/// prediction holds the directions that nothing was seen of. The accelerometer takes no part. Registration has the
/// loop; the contract stands in aslio/stages/estimator.hpp.
class MyStage final : public aslio::Registration {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    Rules rules{.max_iterations = 10, .converged = 1e-3, .min_matches = 50, .degenerate_sigma = 0.05};
    double sigma = 0.1;
    double sigma_rotation = 0.005;
    double sigma_position = 0.02;
    aslio::config::Nested<aslio::Residual> residual{"point_to_plane"};
  };
  /// Names, units, ranges and meanings: what `aslio describe` shows and what a configuration is checked against.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  void reset(const aslio::InitialState& initial) override { restart(initial.state); }
  aslio::NavState predict(std::span<const aslio::ImuSample> imu) const override;

 private:
  aslio::NavState propagate(const aslio::Window& window, aslio::WindowTrajectory& trajectory) override;
  double sigma() const override { return params_.sigma; }
  aslio::Vec6 step(const aslio::Pose& prior, const aslio::Pose& at, const aslio::PoseInformation& all) const override;
  aslio::Mat6 accept(const aslio::Pose& end, const aslio::PoseInformation& fresh, aslio::NavState& state,
                     aslio::StateMatrix& P) override;
  bool trusted(aslio::TimeNs) const override { return true; }

  Params params_;
  aslio::Pose begin_;                                    ///< of the window
  double seconds_ = 0;                                   ///< length of the window [s]
  aslio::Mat6 prior_information_ = aslio::Mat6::Zero();  ///< of the predicted (theta, p)
};

}  // namespace my_plugin
