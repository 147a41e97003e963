#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/toolkit/constant_twist.hpp"
#include "aslio/toolkit/registration.hpp"

namespace aslio::plugins {

/// Registration of one window against the map, LiDAR only (KISS-ICP): the motion goes on as before, points are
/// de-skewed with it, and Gauss-Newton steps with new matches each move the end pose until they are small. The
/// residual's sigma is learnt from how far the prediction was off (docs/equations.md ICP-1, ICP-2).
class Icp final : public Registration {
 public:
  struct Params {
    std::int64_t max_iterations = 500;
    double converged = 1e-4;
    std::int64_t min_matches = 20;
    double initial_threshold = 2.0;
    double min_motion = 0.1;
    double degenerate_sigma = 0.05;
    config::Nested<Residual> residual{"point_to_point"};
  };
  static void describe(config::Binder& b, Params& p);
  Icp(const Params& params, const BuildContext& context);

  bool uses_imu() const override { return false; }
  void reset(const InitialState& initial) override;
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  NavState propagate(const Window& window, WindowTrajectory& trajectory) override;
  double sigma() const override { return threshold(); }
  Mat6 accept(const Pose& end, const PoseInformation& fresh, NavState& state, StateMatrix& P) override;
  bool trusted(TimeNs t) const override { return twist_.believed(t); }
  void begin_map() override { twist_.hold(state().pose(), state().t); }
  void learn_threshold(const Pose& predicted, const Pose& found);
  double threshold() const;

  Params params_;
  double max_range_;
  ConstantTwist twist_;
  double squared_deviations_ = 0;
  int deviations_ = 1;
};

}  // namespace aslio::plugins
