#pragma once
/// The skeleton of an estimator that registers a window as a whole: predict, load the points, match and step until the
/// steps are small, accept or refuse, hand the points over. A method says how it predicts, what a residual's noise is,
/// how a step is solved, and what it learns from an accepted pose.

#include <memory>
#include <vector>

#include "aslio/exec/executor.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_matches.hpp"

namespace aslio {

/// Whether a last step is noise of the association: up to ten times the length below which a step has `converged`. A
/// longer one says that the pose is still on its way.
inline bool settled(double step, double converged) { return step < 10 * converged; }
inline UpdateStatus status_of_last_step(bool is_settled) {
  return is_settled ? UpdateStatus::ok : UpdateStatus::not_converged;
}

/// Spectrum, weakest direction and `unobservable` of an accepted update, by the information of its fresh points about
/// the pose (theta, p); an `ok` one that leaves a direction open becomes `degenerate`. eq. IESKF-7.
void judge_view(Update& update, const Mat6& information, double degenerate_sigma, const WindowPlan& plan);

/// What every update ends with: spans into what the estimator owns, and the points of the frame for all uses.
void hand_over(Update& update, const DeskewedScan& frame, std::span<const MatchRecord> records, const NavState& state,
               std::span<const NavState> states, const TrajectoryModel& trajectory);

class Registration : public Estimator {
 public:
  MapContent map_content() const override {
    return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
  }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  void adopt(const InertialEstimate& better) override { better.put(state_); }

 protected:
  struct Rules {
    std::int64_t max_iterations = 30;
    double converged = 1e-4;         ///< length of a step, rad and m alike
    std::int64_t min_matches = 20;   ///< fewer fresh matches: the step is refused
    double degenerate_sigma = 0.05;  ///< [m], as for judge_view()
  };
  Registration(const Rules& rules, std::unique_ptr<Residual> residual, const BuildContext& context);

  /// Appends the predicted motion over `window`, which begins in state(), to `trajectory`; returns the state at its
  /// end.
  virtual NavState propagate(const Window& window, WindowTrajectory& trajectory) = 0;
  /// Standard deviation of a residual in this update [m].
  virtual double sigma() const = 0;
  /// The step (theta, p) from `at`, given the prediction and the sums over fresh points and weighted old ones.
  virtual Vec6 step(const Pose& prior, const Pose& at, const PoseInformation& all) const;
  /// The pose is accepted; state() is still the prediction, and has to become the posterior, with P. Returns the
  /// information of the fresh points about the pose.
  virtual Mat6 accept(const Pose& end, const PoseInformation& fresh, NavState& state, StateMatrix& P) = 0;
  /// Nothing matched: whether the prediction is still good enough to place points by.
  virtual bool trusted(TimeNs t) const = 0;
  /// The map is empty: the prediction stands.
  virtual void begin_map() {}
  /// At the start of a run.
  void restart(const NavState& state);

 private:
  void load(const Window& window, const HistorySelection& past, const StepContext& context);
  void iterate(const HistorySelection& past, const StepContext& context);
  PoseInformation sum(PointMatches& matches, const Pose& at, double gate);
  void accept(const Pose& end, const PoseInformation& fresh);
  void refuse(UpdateStatus status);
  void finish();

  Rules rules_;
  exec::Executor& exec_;
  std::unique_ptr<Residual> residual_;
  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  double sigma_ = 0;  ///< of this update
  WindowTrajectory trajectory_{WindowTrajectory::Spread::rigid};
  DeskewedScan frame_;
  PointMatches fresh_, history_;
  std::vector<PoseInformation> partials_;
  std::vector<MatchRecord> records_;
  WindowPlan plan_;  ///< of this update
  Update result_;
};

}  // namespace aslio
