#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/begin_end.hpp"
#include "aslio/toolkit/constant_twist.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/imu_track.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_matches.hpp"
#include "aslio/toolkit/registration.hpp"
#include "aslio/toolkit/velocity_search.hpp"

namespace aslio::plugins {

/// Elastic registration of one window (CT-ICP): the poses at its begin and end are both unknown, points lie on the path
/// between them and are de-skewed again at every step; four priors tie the window to the one before (docs/equations.md
/// CT-1 to CT-4). History points hang on the end. LiDAR only, or with the IMU for the prediction.
class CtIcp final : public Estimator {
 public:
  enum class Prediction : std::uint8_t { constant_velocity, imu };

  struct Params {
    Prediction prediction = Prediction::constant_velocity;
    std::int64_t max_iterations = 5;
    std::int64_t max_steps = 5;
    double converged_m = 0.01;
    double converged_deg = 0.1;
    double sigma = 0.03;
    std::int64_t min_matches = 20;
    double degenerate_sigma = 0.05;
    double location = 1e-3;
    double orientation = 0;
    double displacement = 1e-3;
    double turn = 0;
    ImuTrack::Params imu;
    config::Nested<Residual> residual{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  CtIcp(const Params& params, const BuildContext& context);

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  bool uses_imu() const override { return params_.prediction == Prediction::imu; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override { better.put(state_); }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  void propagate(const Window& window);
  void set_path(const Pose& begin, const Pose& end);
  void load(const Window& window, const HistorySelection& past, const StepContext& context);
  void place();
  void associate(const HistorySelection& past, const StepContext& context);
  BeginEndInformation measure(PointMatches& matches, bool fresh, double gate);
  void add_priors(Mat12& A, Vec12& b, double points) const;
  bool step(const StepContext& context, double& turn, double& shift);
  void iterate(const HistorySelection& past, const StepContext& context);
  void refuse(UpdateStatus status);
  void accept();
  void find_velocity_alone();
  void finish();

  Params params_;
  exec::Executor& exec_;
  std::unique_ptr<Residual> residual_;
  ImuTrack imu_;

  InitialState initial_;
  VelocitySearch velocity_;
  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  ConstantTwist twist_;

  NavState begin_, prior_;  ///< ends of the window before anything was measured
  BeginEnd path_;
  WindowTrajectory trajectory_{WindowTrajectory::Spread::rigid};  ///< the same path, for the frame
  DeskewedScan frame_;
  PointMatches fresh_, history_;
  std::vector<double> share_;  ///< of the window that has passed, per fresh match
  std::vector<BeginEndInformation> partials_;
  BeginEndInformation last_;  ///< fresh rows of the last step
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
