#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// Second-order strapdown integration: the mean of two consecutive samples, rotated by the attitude in the middle of
/// the interval (AS-LIO (9)-(10) with the attitude lag of half a step removed; docs/equations.md MOT-1). Inside the
/// interval the rate is that mean, or goes evenly from one sample to the other (docs/equations.md MOT-10).
class ImuMidpoint final : public MotionModel {
 public:
  enum class Rate : std::uint8_t { constant, linear };
  struct Params {
    Rate rate = Rate::constant;
  };
  static void describe(config::Binder& b, Params& p);
  ImuMidpoint(const Params& params, const BuildContext& context);

  MotionSegment step(NavState& state, const ImuSample& from, const ImuSample& to) const override;
  void propagate_covariance(const NavState& before, const ImuSample& from, const ImuSample& to, const ImuNoise& noise,
                            StateMatrix& P) const override;
  void linearise(const NavState& before, const ImuSample& from, const ImuSample& to, StateMatrix& F,
                 Eigen::Matrix<double, kStateDim, 12>& G) const override;

 private:
  Rate rate_;
};

}  // namespace aslio::plugins
