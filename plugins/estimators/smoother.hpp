#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/dead_reckoning.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/imu_noise.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "aslio/toolkit/point_matches.hpp"
#include "aslio/toolkit/registration.hpp"
#include "aslio/toolkit/velocity_search.hpp"
#include "estimators/slice_path.hpp"

namespace aslio::plugins {

/// Iterated error-state smoother over the slices of a window (docs/equations.md SMO-1 to SMO-4). A slice is the fresh
/// interval of an update, or one of the parts that the window strategy cuts it into (WindowPlan::cuts; FR-LIO's
/// sub-frames). Each has a state at its end; the points of a slice measure the poses at both of its ends, each point
/// once. All slices that reach into the window are smoothed together: at every iteration their points are placed and
/// matched again at the smoothed states, those of earlier updates against what was known before them. What leaves the
/// window stays as the belief of its last state. So there is nothing for a history to add, and it has to be `none`.
class Smoother final : public Estimator, private PointRevision {
 public:
  using Gravity = EstimatedStates::Gravity;
  using Noise = ImuNoisePreset::Kind;

  struct Params {
    EstimatedStates estimated;
    ImuNoisePreset noise;
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
  Smoother(const Params& params, const BuildContext& context);

  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  bool uses_history() const override { return false; }
  bool uses_cuts() const override { return true; }
  bool smooths() const override { return true; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override;
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  struct Slice {
    std::uint32_t sequence = 0;  ///< the update that measured it
    std::vector<ImuSample> imu;  ///< that cover it, the first at its begin and the last at its end
    ImuNoisePreset::Circumstances noise_of;
    NavState state;                       ///< at its end: the iterate
    NavState filtered;                    ///< at its end, from this slice and those before it
    StateMatrix P = StateMatrix::Zero();  ///< of `filtered`
    SlicePath path;
    SlicePath placed;  ///< as its own update left it
    PointMatches points;
    std::vector<TimeNs> times;
    std::vector<Vec3> lever;    ///< R(t) p_I
    std::vector<double> share;  ///< of the slice that has passed
    SliceInformation sums;
  };

  void leave(TimeNs history_begin);
  void close();
  void cut(const Window& window);
  Slice& add_slice();
  void hand_out_points();
  NavState trace(Slice& slice, const NavState& begin) const;
  void trace_all();
  bool propagate(const Window& window);
  void stand_still(TimeNs end);
  void predict_covariance();

  Vec3 place(const WorldPoint& point) const override;

  const NavState& begin_of(std::size_t i) const { return i == first_ ? begin_ : slices_[i - 1]->state; }
  void place(Slice& slice) const;
  void associate(const Map& map);
  void measure(Slice& slice);
  std::size_t count_matches();
  void linearise(std::size_t i, SliceEquations& out) const;
  bool step(double& turn, double& shift);
  void iterate(const StepContext& context);
  void accept();
  void find_velocity_alone();
  void refuse(UpdateStatus status);
  void restore();
  SliceInformation fresh_sums() const;
  void record_matches();
  void finish();

  Params params_;
  exec::Executor& exec_;
  SensorModel sensor_;
  std::unique_ptr<MotionModel> motion_;
  std::unique_ptr<Residual> residual_;

  InitialState initial_;
  VelocitySearch velocity_;
  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  UnresolvedMotion unresolved_;
  bool unobservable_ = false;  ///< the last update left a direction open, or was refused after others were not
  DeadReckoning dead_reckoning_;

  // The chain: belief and iterate at its begin, then the slices from first_ on; those from fresh_ on are of this
  // window.
  NavState belief_, begin_;
  StateMatrix belief_P_ = StateMatrix::Zero();
  std::vector<std::unique_ptr<Slice>> slices_, spare_;
  std::size_t first_ = 0, fresh_ = 0;
  std::vector<SliceEquations> equations_;
  SmoothingPass pass_;
  std::vector<NavState> before_;  ///< iterates at the begin of an update: begin of the chain, then slices

  WindowTrajectory carried_{WindowTrajectory::Spread::rigid};  ///< the prediction, for the samplers
  DeskewedScan frame_;
  SliceChain chain_;
  std::vector<NavState> states_;
  std::vector<SliceInformation> partials_;
  std::vector<std::span<Surface>> sets_;  ///< surfaces of all slices
  MatchTally tally_;
  std::vector<MatchRecord> records_, slice_records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio::plugins
