#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "estimators/frame.hpp"
#include "estimators/information_update.hpp"
#include "estimators/initial_covariance.hpp"

namespace aslio::plugins {

/// Iterated error-state Kalman filter over one window: AS-LIO (9)-(13), FAST-LIO2. error state (theta, p, v, b_w, b_a,
/// g, s, d), information form; fresh points are de-skewed to the end of the window with the IMU prediction, history
/// points enter at the world position their own update gave them, seen from the predicted pose (docs/equations.md
/// IESKF-*, HIS-*).
class Ieskf final : public Estimator {
 public:
  using Gravity = EstimatedStates::Gravity;
  using GyroCalibration = EstimatedStates::GyroCalibration;
  enum class Noise : std::uint8_t { fastlio, physical, rate_scaled };
  enum class Association : std::uint8_t { every_iteration, on_convergence, once };

  struct Params {
    EstimatedStates estimated;
    Noise noise = Noise::fastlio;
    Association association = Association::every_iteration;
    std::int64_t max_iterations = 4;
    double sigma = 0.03;
    double converged_m = 1e-3;
    double converged_deg = 0.0573;
    std::int64_t min_matches = 20;
    double degenerate_sigma = 0.05;
    config::Nested<MotionModel> motion{"imu_midpoint"};
    config::Nested<Residual> residual{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  Ieskf(const Params& params, const BuildContext& context);

  void reset(const InitialState& initial) override;
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  /// Points of one class (fresh or history) during the iterations.
  struct MatchSet {
    std::vector<Vec3> body, world;
    std::vector<float> range;
    std::vector<double> weight;  ///< factor on the information of each point; empty: 1
    Neighbours neighbours;
    std::vector<Surface> surfaces;
    std::vector<ResidualRow> rows;
    std::vector<PoseInformation> partials;

    void reserve(std::size_t n, std::size_t rows_per_match, int k);
    void resize(std::size_t n, std::size_t rows_per_match);
  };

  /// Sums of one evaluation: information of the fresh points and of the history points (not yet weighted).
  struct Evaluation {
    PoseInformation fresh, history;
  };

  void find_velocity_alone();
  void propagate(const Window& window);
  ImuNoise noise_of(const ImuSample& from, const ImuSample& to) const;
  void reserve(std::size_t fresh, std::size_t history);
  void load_history(const HistorySelection& past);
  void iterate(const HistorySelection& past, const StepContext& context);
  void associate(MatchSet& set, const NavState& at, const Map& map, std::uint32_t max_stamp);
  PoseInformation evaluate(MatchSet& set, const NavState& at, double gate);
  void accept(const NavState& posterior, const StateMatrix& P_iterate, const Evaluation& last, const Mat6& A_all,
              const HistorySelection& past);
  void refuse(UpdateStatus status);
  bool dead_reckoning_is_good() const;
  void finish();

  Params params_;
  exec::Executor& exec_;
  SensorModel sensor_;
  std::unique_ptr<MotionModel> motion_;
  std::unique_ptr<Residual> residual_;

  InitialState initial_;
  int velocity_updates_ = 0;  ///< accepted updates of a dynamic start
  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  // Growth of the uncertainty since the last accepted update decides how long dead reckoning may extend the map.
  TimeNs accepted_t_ = kTimeMin;
  double accepted_position_variance_ = 0, accepted_tilt_variance_ = 0;

  RigidTrajectory trajectory_;
  Frame frame_;
  MatchSet fresh_, history_;
  std::vector<NavState> states_;
  std::vector<MatchRecord> records_;
  Update result_;
};

}  // namespace aslio::plugins
