#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// First-order integration as in FAST-LIO and FAST-LIO2: the mean of two consecutive samples rotated by the attitude at
/// the START of the interval, no dt^2 term in the position (docs/equations.md MOT-4).
class ImuEuler final : public MotionModel {
 public:
  struct Params {};
  static void describe(config::Binder& b, Params& p);
  ImuEuler(const Params& params, const BuildContext& context);

  MotionSegment step(NavState& state, const ImuSample& from, const ImuSample& to) const override;
  void propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to, const ImuNoise& noise,
                            StateMatrix& P) const override;
  void linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                 Eigen::Matrix<double, kStateDim, 12>& G) const override;
};

}  // namespace aslio::plugins
