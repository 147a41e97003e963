#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// Second-order strapdown integration: the mean of two consecutive samples, rotated by the attitude in the middle of
/// the interval (AS-LIO (9)-(10) with the attitude lag of half a step removed; docs/equations.md MOT-1).
class ImuMidpoint final : public MotionModel {
 public:
  struct Params {};
  static void describe(config::Binder& b, Params& p);
  ImuMidpoint(const Params& params, const BuildContext& context);

  MotionSegment step(NavState& state, const ImuSample& from, const ImuSample& to) const override;
  void propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to, const ImuNoise& noise,
                            StateMatrix& P) const override;
  void linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                 Eigen::Matrix<double, kStateDim, 12>& G) const override;
};

}  // namespace aslio::plugins
