#pragma once
/// Motions: pose and covariance between updates.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "aslio/config/nested.hpp"
#include "aslio/core/types.hpp"
#include "aslio/stages/build_context.hpp"

namespace aslio {

inline constexpr int kStateDim = 28;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;
using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

/// Offsets of the blocks of the error state (theta, p, v, b_w, b_a, g, s, d).
namespace block {
inline constexpr int theta = 0, p = 3, v = 6, b_w = 9, b_a = 12, g = 15, s = 18, d = 27;
}

/// Noise of one IMU interval as discrete per-sample variances of (n_w, n_a, n_bw, n_ba), isotropic per block but for
/// what single axes have beyond it. A continuous density sigma_c enters as sigma_c^2 / dt (docs/equations.md MOT-3).
struct ImuNoise {
  double gyro = 0;       ///< [(rad/s)^2]
  double acc = 0;        ///< [(m/s^2)^2]
  double gyro_bias = 0;  ///< of the bias rate [(rad/s^2)^2]
  double acc_bias = 0;   ///< of the bias rate [(m/s^3)^2]
  /// What axes of I have beyond `gyro` and `acc`, where a sample is not believed (MOT-12). Zero as a rule.
  Vec3 gyro_axes = Vec3::Zero();  ///< [(rad/s)^2]
  Vec3 acc_axes = Vec3::Zero();   ///< [(m/s^2)^2]

  /// Whether an axis has more noise than another.
  bool uneven() const { return gyro_axes.maxCoeff() > 0 || acc_axes.maxCoeff() > 0; }
};

/// One integration interval [t, t + dt] with constant world acceleration and a corrected rate that changes evenly:
/// R(tau) = R Exp(w tau) Exp(w_dot tau (tau - dt) / 2), p(tau) = p + v tau + a_W tau^2 / 2 for tau in [0, dt]
/// (docs/equations.md DSK-1).
struct MotionSegment {
  TimeNs t = 0;
  double dt = 0;
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();      ///< bias-corrected angular rate, mean of the interval [rad/s]
  Vec3 a_W = Vec3::Zero();    ///< acceleration of the origin of I in W, gravity included [m/s^2]
  Vec3 w_dot = Vec3::Zero();  ///< change of the rate [rad/s^2]; zero where it counts as constant

  Pose pose(TimeNs at) const {
    const double tau = to_seconds(at - t);
    return {R * exp_so3(w * tau) * exp_so3(bend(tau) * w_dot), p + v * tau + 0.5 * tau * tau * a_W};
  }
  /// What w_dot adds to the rotation after tau, in units of w_dot: nothing at either end.
  double bend(double tau) const { return 0.5 * tau * (tau - dt); }
};

/// Contract. step() advances the state over one interval between two consecutive IMU samples and returns the segment it
/// assumed; linearise() gives the exact first-order transition of that step for the error (theta, p, v, b_w, b_a, g, s,
/// d): F (28x28) and G Q G^T added to P by propagate_covariance(). Stateless; thread-safe; no allocation.
class MotionModel : public Stage {
 public:
  static constexpr std::string_view family = "motions";
  virtual MotionSegment step(NavState& state, const ImuSample& from, const ImuSample& to) const = 0;
  /// P <- F P F^T + G Q G^T for the step from `before` over the same samples.
  virtual void propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to,
                                    const ImuNoise& noise, StateMatrix& P) const = 0;
  /// The dense F and G (noise order n_w, n_a, n_bw, n_ba) of the step, for tests and smoothers.
  virtual void linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                         Eigen::Matrix<double, kStateDim, 12>& G) const = 0;
};

}  // namespace aslio
