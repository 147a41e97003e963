#pragma once
/// The states of the last windows, smoothed together; what leaves stays as a prior of the oldest (fixed lag).

#include <memory>
#include <vector>

#include "estimators/inertial_terms.hpp"

namespace aslio::plugins {

class LagWindow {
 public:
  struct Params {
    std::int64_t lag = 20;
    std::int64_t max_iterations = 10;
    double sigma_rotation = 0.05;   ///< of a registration [rad]
    double sigma_position = 0.1;    ///< [m]
    double sigma_degenerate = 1.0;  ///< both, of one that left a direction open
    InertialNoise noise;
  };
  explicit LagWindow(const Params& params) : params_(params) {}

  bool empty() const { return nodes_.empty(); }
  void clear();
  /// One state, known to `sigma`: of the attitude, about the axes of the world, whose z is up.
  void start(const NavState& state, const Vec15& sigma);
  /// The next state, `motion` after the newest; `guess` is where it is thought to be. Pre: not empty.
  void append(const Preintegration& motion, const NavState& guess);
  /// The pose of the newest state as registered.
  void measure(const Pose& pose, bool degenerate);
  /// All states at the least sum of squares; then what is beyond the lag leaves. False: no usable solution.
  bool solve();

  const NavState& newest() const { return nodes_.back(); }
  /// Of the newest state, as of the last solve().
  const Mat15& covariance() const { return covariance_; }
  std::size_t size() const { return nodes_.size(); }

 private:
  /// J^T J and J^T r of all terms: blocks of a chain.
  struct NormalEquations {
    std::vector<Mat15> own, below;  ///< of each state; of the next state with it
    std::vector<Vec15> slope;
    double cost = 0;  ///< sum of squares
  };

  void add(const StateTerm& term, const std::vector<NavState>& nodes, NormalEquations& normal) const;
  NormalEquations linearise(const std::vector<NavState>& nodes) const;
  bool step(const NormalEquations& normal, double damping);
  bool drop_oldest();

  Params params_;
  std::vector<NavState> nodes_;
  std::vector<std::unique_ptr<StateTerm>> terms_;
  std::vector<Vec15> moves_;  ///< of a step
  Mat15 covariance_ = Mat15::Identity();
};

}  // namespace aslio::plugins
