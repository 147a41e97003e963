#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/dead_reckoning.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "aslio/toolkit/registration.hpp"
#include "aslio/toolkit/velocity_search.hpp"
#include "estimators/cube_means.hpp"
#include "estimators/knot_trajectory.hpp"
#include "estimators/pointwise_state.hpp"

namespace aslio::plugins {

/// Error-state Kalman filter that takes points and IMU samples in the order of time, one update per firing, so that
/// nothing needs de-skewing (He et al., Point-LIO, 2023). Angular rate and specific force are states; the IMU measures
/// them, and an axis at the limit of its range is left out. Each point counts at its own moment and
/// no second time, so the history has to be `none`. The window decides when points are taken in and enter the map, not
/// when the state is updated (docs/equations.md PTW-1 to PTW-5). Update::states has a state per firing.
class PointwiseEskf final : public Estimator {
 public:
  using Gravity = EstimatedStates::Gravity;
  /// Which points the first map is made of.
  enum class FirstMap : std::uint8_t { sampled, all };

  struct Params {
    Gravity gravity = Gravity::s2;
    double sigma = 0.1;
    PointwiseNoise noise;
    double gyro_variance = 0.1;
    double acc_variance = 0.1;
    double gyro_saturation = 35.0;
    double acc_saturation = 3 * kStandardGravity;
    double imu_step = 0.01;
    double covariance_step = 0.01;
    double mean_leaf = 0;
    FirstMap first_map = FirstMap::sampled;
    std::int64_t min_matches = 20;
    double degenerate_sigma = 0.05;
    config::Nested<Residual> residual{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  PointwiseEskf(const Params& params, const BuildContext& context);

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  bool uses_history() const override { return false; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override;
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  /// Filter and time to which its covariance has been carried.
  struct Belief {
    PointwiseState x;
    pointwise::Matrix P = pointwise::Matrix::Zero();
    TimeNs covariance_t = 0;
  };

  void sample(const Window& window, const StepContext& context);
  void sample_means(std::span<const TimedPoint> fresh, SamplerChain& samplers);
  void reset_covariance(double sigma_velocity);
  void find_velocity_alone(const PointwiseState& begin);
  ImuSample between(const ImuSample& from, const ImuSample& to, double share) const;
  void load_imu(const Window& window);
  void follow(const Window& window, const Map* map);
  void advance(TimeNs t);
  void carry_covariance();
  void correct(const SequentialUpdate& update);
  void mark();
  void take_imu(const ImuSample& sample);
  void take_points(std::size_t begin, std::size_t end, const Map& map);
  void accept(const PointwiseState& begin);
  void refuse(UpdateStatus status);
  void finish();

  Params params_;
  std::unique_ptr<Residual> residual_;

  InitialState initial_;
  VelocitySearch velocity_;
  Belief now_;
  NavState state_;
  DeadReckoning dead_reckoning_;

  DeskewedScan frame_;
  CubeMeans means_;
  SamplerChain no_samplers_;
  std::vector<PointUses> uses_;
  KnotTrajectory trajectory_;
  // Of one firing.
  std::vector<Vec3> world_;
  std::vector<Surface> surfaces_;
  std::vector<ResidualRow> rows_;
  std::vector<Vec6> row_slopes_;
  Neighbours neighbours_;
  // Of the window.
  std::vector<ImuSample> imu_;  ///< of the window after its begin, up to its end
  std::size_t readings_ = 0;    ///< of them that are readings: all, or all but the last
  Mat6 information_ = Mat6::Zero();
  double nis_sum_ = 0;
  std::size_t nis_rows_ = 0;
  std::vector<NavState> states_;
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
