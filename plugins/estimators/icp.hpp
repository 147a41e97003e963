#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "estimators/constant_twist.hpp"
#include "estimators/frame.hpp"
#include "estimators/information_update.hpp"
#include "estimators/point_matches.hpp"

namespace aslio::plugins {

/// Registration of one window against the map, LiDAR only (KISS-ICP): the motion goes on as before, points are
/// de-skewed with it, and Gauss-Newton steps with new matches each move the end pose until they are small. The
/// residual's sigma is learnt from how far the prediction was off (docs/equations.md ICP-1, ICP-2).
class Icp final : public Estimator {
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

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  bool uses_imu() const override { return false; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override { better.put(state_); }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  void propagate(TimeNs end);
  void load(const Window& window, const HistorySelection& past, const StepContext& context);
  void iterate(const HistorySelection& past, const StepContext& context);
  PoseInformation sum(PointMatches& matches, const Pose& at, double gate);
  void refuse(UpdateStatus status);
  void accept(const Pose& end, const PoseInformation& fresh);
  void learn_threshold(const Pose& predicted, const Pose& found);
  double threshold() const;
  void finish();

  Params params_;
  exec::Executor& exec_;
  double max_range_;
  std::unique_ptr<Residual> residual_;

  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  ConstantTwist twist_;
  double squared_deviations_ = 0;
  int deviations_ = 1;
  double matched_within_ = 0;  ///< threshold() of this update [m]

  Pose begin_;  ///< of the window
  WindowTrajectory trajectory_{WindowTrajectory::Spread::rigid};
  Frame frame_;
  PointMatches fresh_, history_;
  std::vector<PoseInformation> partials_;
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
