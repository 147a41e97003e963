#pragma once

#include <limits>
#include <span>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/dead_reckoning.hpp"
#include "aslio/toolkit/imu_noise.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "aslio/toolkit/registration.hpp"
#include "aslio/toolkit/velocity_search.hpp"
#include "estimators/directional_weights.hpp"
#include "estimators/sensor_states.hpp"
#include "estimators/window_matches.hpp"
#include "estimators/window_path.hpp"

namespace aslio::plugins {

/// Iterated error-state Kalman filter over one window: AS-LIO (9)-(13), FAST-LIO2. error state (theta, p, v, b_w, b_a,
/// g, s, d), information form; fresh points are de-skewed to the end of the window with the IMU prediction, history
/// points enter at the world position their own update gave them, seen from the predicted pose (docs/equations.md
/// IESKF-*, HIS-*).
class Ieskf final : public Estimator {
 public:
  using Gravity = EstimatedStates::Gravity;
  using Noise = ImuNoisePreset::Kind;
  enum class Association : std::uint8_t { every_iteration, on_convergence, once };

  /// Which components of a step must be small for it to have converged.
  enum class Converged : std::uint8_t { pose, state };
  /// Which variances the filter starts with.
  enum class StartCovariance : std::uint8_t { measured, fastlio };

  /// How a window's correction reaches the points inside it.
  enum class DeskewCorrection : std::uint8_t {
    rigid,       ///< they move with the end of the window
    linear,      ///< the correction grows from the begin to the end, in the rows too
    asymptotic,  ///< the same, points only: de-skewed again at every iteration (AC-LIO)
    state  ///< de-skewed again through the IMU with the rate, velocity and calibration of the iterate, in the rows too
  };

  /// With `asymptotic`: which steps of an update reach the points in proportion to their time. The others move all
  /// points alike, as `rigid`. eq. DSK-4.
  enum class Redeskew : std::uint8_t {
    every_iteration,  ///< all of them
    once_registered,  ///< from the first one on that starts with an RMS residual of at most `redeskew_below`
    until_converged   ///< up to the first one before which the RMS residual has fallen by less than `redeskew_fall`
  };

  struct Params {
    EstimatedStates estimated;
    StartCovariance start_covariance = StartCovariance::measured;
    SensorStates::Params sensors;
    DeskewCorrection deskew_correction = DeskewCorrection::rigid;
    Redeskew redeskew = Redeskew::every_iteration;
    double redeskew_below = 0.05;
    double redeskew_fall = 0.01;
    ImuNoisePreset noise;
    Association association = Association::every_iteration;
    bool search_last = false;
    bool gate_again = true;
    std::int64_t max_iterations = 4;
    double sigma = 0.03;
    double converged_m = 1e-3;
    double converged_deg = 0.0573;
    Converged converged = Converged::pose;
    std::int64_t min_matches = 20;
    double shared_time = 0.05;
    double degenerate_sigma = 0.05;
    DirectionalWeights::Params directional;
    config::Nested<MotionModel> motion{"imu_midpoint"};
    config::Nested<Residual> residual{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  Ieskf(const Params& params, const BuildContext& context);

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override { better.put(state_); }
  void set_noise_scale(double scale) override {  // eq. NOI-2
    sigma_ = params_.sigma * scale;
    residual_->set_noise_scale(scale);
  }
  void doubt_gyro_bias(double sigma) override {  // eq. MOT-13
    P_.diagonal().segment<3>(block::b_w).array() += sigma * sigma;
  }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;
  /// Steps of the last update that reached the points in proportion to their time, or through the IMU. eq. DSK-4.
  int redeskews() const { return redeskews_; }

 private:
  /// Sums of one evaluation: information of the fresh points and of the history points (not yet weighted).
  struct Evaluation {
    WindowInformation fresh, history;
  };
  /// Normal equations of what the points see: of fresh residuals, and of all with the history weighted.
  struct NormalEquations {
    SeenMatrix A_new, A_all;
    SeenVector b_all;
  };

  StateMatrix start_covariance(double sigma_velocity) const;
  void find_velocity_alone();
  void propagate(const Window& window);
  void reserve(std::size_t fresh, std::size_t history);
  void iterate(const HistorySelection& past, const StepContext& context);
  /// What the points match where `at` has placed them.
  void associate(WindowMatches& set, const NavState& at, const Map& map, std::uint32_t max_stamp);
  void project_to_seen(const WindowInformation& sum, SeenMatrix& A, SeenVector& b) const;
  void load_fresh();
  bool spreads(const WindowInformation& fresh);
  void redeskew(const Pose& before, const NavState& at, const WindowInformation& fresh);
  void correct_trajectory();
  bool has_converged(const StateVector& delta) const;
  bool searches_next(int iteration, bool converged, int converged_steps) const;
  Evaluation linearize(const NavState& at, const StepContext& context);
  void find_weak_directions(const NavState& at, const WindowInformation& fresh);
  double innovation_per_row(const WindowInformation& fresh) const;
  StateVector step(const NavState& at, const StateVector& d, const StateMatrix& P, const NormalEquations& normal);
  NormalEquations assemble(const Evaluation& sums, double history_weight) const;
  void accept(const NavState& posterior, const StateMatrix& P_iterate, const NormalEquations& normal,
              const HistorySelection& past);
  void refuse(UpdateStatus status);
  void record_residuals();
  void finish(bool predicted);

  Params params_;
  double sigma_;  ///< of a residual, for the noise there is [m]
  exec::Executor& exec_;
  SensorModel sensor_;
  std::unique_ptr<MotionModel> motion_;
  std::unique_ptr<Residual> residual_;

  InitialState initial_;
  VelocitySearch velocity_;
  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  SensorStates sensors_;
  DeadReckoning dead_reckoning_;
  UnresolvedMotion unresolved_;
  bool unobservable_ = false;  ///< the last update left a direction open, or was refused after others were not

  Pose spread_end_;        ///< of the predicted end and the steps that reached the points in proportion to their time
  bool spreading_ = true;  ///< whether the last step did
  double rms_ = 0;         ///< of the residuals before it [m]
  int redeskews_ = 0;

  SeenRows seen_ = SeenRows::Zero();
  WindowPath path_;
  DeskewedScan frame_;
  WindowMatches fresh_, history_;
  DirectionalWeights directions_;
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
