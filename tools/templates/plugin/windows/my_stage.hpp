#pragma once

#include <optional>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"

namespace my_plugin {

/// When is the next update, and over which points? Here: after a fixed period, which shortens while the carrier turns.
/// The contract stands in aslio/stages/window.hpp.
class MyStage final : public aslio::WindowStrategy {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    double period = 0.1;
    double turning_period = 0.05;
    double turn_rate = 1.0;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  std::optional<aslio::WindowPlan> next(const aslio::StreamView& stream, const aslio::Feedback& feedback,
                                        aslio::OverlapProbe& probe) override;
  /// The stream must keep the IMU samples of the last period.
  aslio::TimeNs reach() const override { return period_; }

 private:
  bool turned(const aslio::StreamView& stream, aslio::TimeNs t) const;

  aslio::TimeNs period_, turning_period_;
  double turn_rate_;  ///< [rad/s]
};

}  // namespace my_plugin
