#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/constant_twist.hpp"
#include "aslio/toolkit/dead_reckoning.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "aslio/toolkit/point_matches.hpp"
#include "aslio/toolkit/registration.hpp"
#include "aslio/toolkit/velocity_search.hpp"
#include "estimators/spline_trajectory.hpp"

namespace aslio::plugins {

/// Recursive spline (RESPLE; Cao, Talbot and Li, RA-L 2025): the state is the last four control poses of a uniform
/// cubic B-spline, with the IMU's biases and gravity. Every point and every IMU sample is measured at its own time on
/// the spline, so that nothing needs de-skewing. An iterated Kalman filter takes the measurements of one interval
/// between knots at a time (docs/equations.md SPL-1 to SPL-10). Each point counts once, so the history has to be
/// `none`. The window decides when points are taken in and enter the map, not when the state is updated. With `imu:
/// false` no IMU is read. Update::states has a state per knot.
class SplineIekf final : public Estimator {
 public:
  using Gravity = EstimatedStates::Gravity;

  struct Params {
    bool imu = true;
    Gravity gravity = Gravity::s2;
    double interval = 0.01;
    SplineNoise noise;
    double sigma = 0.1;
    double gyro_variance = 0.1;
    double acc_variance = 1.0;
    std::int64_t batch_points = 500;
    std::int64_t max_iterations = 3;
    double converged = 1e-4;
    std::int64_t min_matches = 20;
    double degenerate_sigma = 0.05;
    config::Nested<Residual> residual{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  SplineIekf(const Params& params, const BuildContext& context);

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  bool uses_imu() const override { return params_.imu; }
  bool uses_history() const override { return false; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override;
  void set_noise_scale(double scale) override;
  void doubt_gyro_bias(double sigma) override;
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  /// What is measured within one segment: IMU samples and matches of the window, by position.
  struct Batch {
    std::size_t imu_begin = 0, imu_end = 0, points_begin = 0, points_end = 0;
    std::size_t points() const { return points_end - points_begin; }
  };

  void reset_covariance(double sigma_velocity);
  void sample(const Window& window, const StepContext& context);
  void advance(TimeNs t);
  bool follow(const Window& window, const Map* map);
  Batch next_batch(std::size_t imu, std::size_t point, std::size_t points) const;
  bool take(const Batch& batch, const Map* map);
  void place(const Batch& batch, const CubicSplineSegment& segment);
  void match(const Batch& batch, const CubicSplineSegment& segment, const Map& map);
  SplineInformation measure_points(const Batch& batch, const CubicSplineSegment& segment, Mat6& pose);
  void measure_imu(const Batch& batch, const CubicSplineSegment& segment, SplineInformation& information) const;
  void record(const Batch& batch, const CubicSplineSegment& segment);
  void find_velocity_alone(const NavState& begin);
  void accept(const NavState& begin);
  void refuse(UpdateStatus status);
  void stay(TimeNs t);
  void finish();

  Params params_;
  std::unique_ptr<Residual> residual_;
  double noise_scale_ = 1;

  InitialState initial_;
  VelocitySearch velocity_;
  SplineBelief now_;
  NavState state_;
  DeadReckoning dead_reckoning_;
  ConstantTwist twist_;  ///< without IMU: how the motion goes on

  DeskewedScan frame_;
  SplineTrajectory trajectory_;
  PointMatches batch_;
  std::span<const ImuSample> imu_;  ///< readings of the window after its begin
  Mat6 information_ = Mat6::Zero();
  double nis_sum_ = 0;
  std::size_t nis_rows_ = 0;
  std::int64_t iterations_ = 0;  ///< most of a batch
  std::vector<NavState> states_;
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
