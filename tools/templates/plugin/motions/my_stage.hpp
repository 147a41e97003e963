#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/motion.hpp"

namespace my_plugin {

/// How do pose and covariance evolve between updates? Here: the later IMU sample of an interval holds over all of it.
/// The contract stands in aslio/stages/motion.hpp.
class MyStage final : public aslio::MotionModel {
 public:
  /// Parameters and their defaults would stand here; this stage has none.
  struct Params {};
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  aslio::MotionSegment step(aslio::NavState& state, const aslio::ImuSample& from,
                            const aslio::ImuSample& to) const override;
  void propagate_covariance(const aslio::NavState& before, const aslio::ImuSample& from, const aslio::ImuSample& to,
                            const aslio::ImuNoise& noise, aslio::StateMatrix& P) const override;
  void linearise(const aslio::NavState& before, const aslio::ImuSample& from, const aslio::ImuSample& to,
                 aslio::StateMatrix& F, Eigen::Matrix<double, aslio::kStateDim, 12>& G) const override;
};

}  // namespace my_plugin
