#pragma once
/// Estimators: the state, given a window, its history and the map.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "aslio/stages/history.hpp"
#include "aslio/stages/map.hpp"
#include "aslio/stages/motion.hpp"
#include "aslio/stages/residual.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

/// How the state at start was found (docs/equations.md INI-1, INI-2, INI-6).
enum class InitialMode : std::uint8_t {
  static_start,   ///< at rest
  dynamic_start,  ///< in motion, the velocity unknown: the first updates find it (INI-3)
  moving_start    ///< in motion, the velocity known from the first sweeps
};

/// What initialisation knows: the state and one standard deviation per block.
struct InitialState {
  NavState state;
  InitialMode mode = InitialMode::static_start;
  Vec3 rate = Vec3::Zero();       ///< moving_start without IMU: turn rate, in I [rad/s]
  double sigma_tilt = 0.02;       ///< roll and pitch against gravity [rad]
  double sigma_velocity = 0.01;   ///< [m/s]
  double sigma_gyro_bias = 1e-3;  ///< [rad/s]
  double sigma_acc_bias = 0.2;    ///< [m/s^2]
};

/// Continuous pose over (part of) a window: the pivot between estimators and everything that places points.
class TrajectoryModel {
 public:
  virtual ~TrajectoryModel() = default;
  /// T_W_I at t.
  virtual Pose pose(TimeNs t) const = 0;
  /// Number of unknowns.
  virtual int dof() const = 0;
  /// T_W_I at t if every unknown were moved by its part of xi (length dof): poses by R Exp(theta) [rad], p + dp [m].
  virtual Pose moved(TimeNs t, const Eigen::VectorXd& xi) const = 0;
  /// d(theta, p)(t) / d xi, 6 x dof, right perturbation of R, additive p: the slope of moved() at xi = 0. `out` is
  /// resized.
  virtual void jacobian(TimeNs t, Eigen::MatrixXd& out) const = 0;
};

/// A match of a fresh point in the last association: position in Update::points(PointUse::match), and its neighbours.
struct MatchRecord {
  bool accepted = false;  ///< the map had a surface there, and no gate left the match out
  float residual = 0;     ///< of a match, signed z at the posterior [m]; of several rows, the length of their vector
  bool matched = false;   ///< the map had a surface there
};

/// Where an estimator that corrects earlier poses, too, holds points of earlier updates now.
class PointRevision {
 public:
  virtual ~PointRevision() = default;
  /// p_W of a point that its own update placed at `point.p_W`. What has left the window stays where it is.
  virtual Vec3 place(const WorldPoint& point) const = 0;
};

/// CPU time of the calling thread per part [s], disjoint; never used in a decision.
struct StageTimes {
  double predict = 0, deskew = 0, sample = 0, associate = 0, solve = 0, overlap = 0, insert = 0, window = 0;
};

/// What an estimator has learnt of the sensors beside the state (NavState). A sigma of 0: it is held fixed.
struct SensorEstimate {
  Pose T_imu_lidar;                       ///< as estimated
  Pose declared;                          ///< T_imu_lidar of the sensor file
  Vec3 sigma_rotation = Vec3::Zero();     ///< of T_imu_lidar, about its axes [rad]
  Vec3 sigma_translation = Vec3::Zero();  ///< of T_imu_lidar [m]
  Vec3 acc_scale = Vec3::Zero();          ///< error of the accelerometer's scale factors: it measures (1 + s)(a + b_a)
  Vec3 sigma_acc_scale = Vec3::Zero();
};

/// Result of one update. Owned by the estimator, valid until its next update; spans point into it.
struct Update {
  UpdateStatus status = UpdateStatus::initialising;
  bool accepted = false;  ///< the state was corrected by this window's points
  /// The points may enter map, overlap and history. False after a refused step, unless the dead reckoning that placed
  /// them is still good: in space never seen before there is nothing to match.
  bool insert = true;
  bool unobservable = false;  ///< the points left a direction unknown (`degenerate`, or hidden by `not_converged`)
  bool restart_map = false;   ///< the map must start again with these points: its own points are placed too badly
  NavState prior;             ///< at the end of the window, propagated
  NavState state;             ///< posterior (equals the prior when not accepted)
  StateMatrix P = StateMatrix::Zero();
  std::array<double, 6> spectrum{};  ///< eigenvalues of the pose information (theta, p) of the fresh points, ascending
  Vec6 weakest = Vec6::Zero();  ///< direction of the least of them: theta (I, at 5 m of lever arm), p (W); 0: not known
  int iterations = 0;
  std::uint32_t fresh_matches = 0;
  std::uint32_t history_matches = 0;
  std::uint32_t history_points = 0;  ///< offered by the history policy
  double residual_rms = 0;           ///< of accepted fresh residuals [m]
  double nis = 0;  ///< squared innovation of the fresh residuals at the prior, per row (eq. IESKF-10); 0: none
  std::span<const NavState> states;             ///< states inside the window in time order, the last is `state`
  const TrajectoryModel* trajectory = nullptr;  ///< T_W_I over the fresh interval
  /// Of points of this update and earlier ones; valid as long as the estimator. nullptr: they stay where they are.
  const PointRevision* revision = nullptr;
  std::optional<SensorEstimate> sensor;  ///< where one is estimated
  StageTimes times;

  /// One that says so by its status alone means it, too.
  bool unobservable_direction() const { return unobservable || status == UpdateStatus::degenerate; }
  std::span<const WorldPoint> points(PointUse use) const {
    return use == PointUse::overlap ? overlap_points : use == PointUse::map ? map_points : match_points;
  }
  std::span<const WorldPoint> overlap_points, map_points, match_points;
  std::span<const MatchRecord> matches;    ///< one per match_points
  const Neighbours* neighbours = nullptr;  ///< last neighbour list of every match, same order
};

/// Everything an update may use besides its window; the map is const.
struct StepContext {
  SamplerChain& samplers;
  const Map& map;
  const HistoryPolicy& histories;
};

/// What an estimator behind another one knows better.
struct InertialEstimate {
  Vec3 v = Vec3::Zero();    ///< [m/s], in W
  Vec3 b_w = Vec3::Zero();  ///< of the gyro [rad/s]
  Vec3 b_a = Vec3::Zero();  ///< of the accelerometer [m/s^2]

  static InertialEstimate of(const NavState& state) { return {state.v, state.b_w, state.b_a}; }
  void put(NavState& state) const {
    state.v = v;
    state.b_w = b_w;
    state.b_a = b_a;
  }
};

/// Contract. reset() before the first update. update(): predict to the end of the window, de-skew, sample, associate,
/// solve. With an empty map there is nothing to match: status `initialising`, the prior is kept and points are placed
/// with it. A refused step keeps the prior. The map is asked from where the sensor is (MapQuery::viewpoint), and points
/// carry the direction they are seen in (WorldPoint::view). Never throws on numerical trouble (UpdateStatus says it).
/// Same bits for any number of threads. No allocation after warm-up.
class Estimator : public Stage {
 public:
  static constexpr std::string_view family = "estimators";
  /// What its map has to hold.
  virtual MapContent map_content() const { return MapContent::points; }
  /// Whether it takes IMU data. If not, no stage sees any: windows do not wait for it, Window::imu is empty, and the
  /// first state is that of the first point, at rest in the origin of W with the axes of I.
  virtual bool uses_imu() const { return true; }
  /// Whether it takes points of earlier updates. If not, the history has to be `none`.
  virtual bool uses_history() const { return true; }
  /// Whether it makes anything of WindowPlan::cuts. If not, the window has to give none.
  virtual bool uses_cuts() const { return false; }
  /// Whether it asks for points by their feature_class. If so, a sampler has to set it.
  virtual bool uses_features() const { return false; }
  /// Whether it goes on with states of earlier windows, which adopt() ends: then no smoother can wrap it.
  virtual bool smooths() const { return false; }
  virtual void reset(const InitialState& initial) = 0;
  /// state() has this velocity and these biases from here on, as from a smoother that wraps this estimator. Its pose
  /// and what the estimator remembers of earlier windows stay; one without IMU predicts from its poses, as before.
  virtual void adopt(const InertialEstimate& better) = 0;
  /// Lengths that are about the noise of points count so many times what the parameters say, those of its residual,
  /// too; > 0. Between updates. One that does nothing keeps its numbers.
  virtual void set_noise_scale(double scale) { (void)scale; }
  /// The gyro's bias may be off by `sigma` [rad/s] per axis more than the estimator thinks: it stepped. Between
  /// updates. One that keeps no covariance of it goes on.
  virtual void doubt_gyro_bias(double sigma) { (void)sigma; }
  virtual const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) = 0;
  /// Posterior state of the last update.
  virtual const NavState& state() const = 0;
  /// Prediction from the last posterior over `imu` (first sample at the state's time), without changing anything. An
  /// estimator without IMU takes nothing but the time of the last sample.
  virtual NavState predict(std::span<const ImuSample> imu) const = 0;
};

}  // namespace aslio
