#pragma once
/// `motion_rate`: two rates, chosen by the gyro. The control of the adaptive window: it sees how fast the sensor turns,
/// not what comes into view. (WIN-5)

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"
#include "aslio/toolkit/tiling.hpp"

namespace aslio::plugins {

class MotionRateWindow final : public WindowStrategy {
 public:
  struct Params {
    double frame_length = 0.1;
    std::optional<double> slow_period = std::nullopt;  ///< [s]; none: frame_length
    double fast_period = 0.02;
    double threshold_deg = 60.0;
    double hold = 0.2;
    std::int64_t min_points = 300;
  };
  static void describe(config::Binder& b, Params& p);

  MotionRateWindow(const Params& params, const BuildContext& context);

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override;
  bool decides_by_imu() const override { return true; }

 private:
  /// Time of the first sample in (begin, end] that turns faster than the threshold.
  std::optional<TimeNs> turn_in(const StreamView& stream, TimeNs begin, TimeNs end, const Vec3& gyro_bias) const;
  std::optional<TimeNs> wanted_shift(const StreamView& stream, const Feedback& feedback) const;

  TimeNs frame_length_;
  TimeNs slow_period_;
  TimeNs fast_period_;
  TimeNs hold_;
  double squared_threshold_;  ///< [rad^2/s^2]
  TileRequest request_;       ///< constants of every request; begin and shift are those of the pending window
};

}  // namespace aslio::plugins
