#pragma once
/// `sod_adaptive`: the window of AS-LIO. The lower the spatial overlap of the last frame with the map, the sooner the
/// next update. (AS-LIO section III-C, eqs. (7)-(8); WIN-1, WIN-2)

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"
#include "aslio/toolkit/tiling.hpp"
#include "windows/segment_schedule.hpp"

namespace aslio::plugins {

class SodAdaptiveWindow final : public WindowStrategy {
 public:
  struct Params {
    double frame_length = 0.1;
    double seg_step = 0.1;
    std::int64_t n_min = 2;
    std::int64_t n_max = 25;
    double shift_min = 0.008;
    double warmup = 1.0;
    bool echo = true;
    Recover recover = Recover::step;
    bool lookahead = false;
    std::int64_t min_points = 300;
    std::int64_t weak_segments = 2;
    std::int64_t imu_samples = 1;
  };
  static void describe(config::Binder& b, Params& p);

  SodAdaptiveWindow(const Params& params, const BuildContext& context);

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override { return frame_length_; }

 private:
  bool warming_up(const Feedback& feedback) const;
  void absorb(const Feedback& feedback);
  bool look_ahead(const StreamView& stream, TimeNs begin, OverlapProbe& probe);
  /// Whether points or IMU data were missing for more than two frame lengths before or within (begin, end].
  bool follows_gap(const StreamView& stream, TimeNs begin, TimeNs end);
  /// Takes note of the time between IMU samples, those of a window behind those before; what is older than some two
  /// seconds counts half, older than four a quarter.
  void pace(std::span<const ImuSample> imu);
  /// Whether the IMU has said nothing that can be believed for too long before `t`, or not long before.
  bool unread(TimeNs t);

  TimeNs frame_length_;
  TimeNs warmup_;
  bool lookahead_;
  std::int64_t weak_segments_;
  std::int64_t imu_samples_;
  TileRequest request_;  ///< constants of every request; begin and shift are those of the pending window
  SegmentSchedule schedule_;
  bool awaits_feedback_ = false;  ///< a window was returned and its feedback not yet seen
  TimeNs probed_ = 0;             ///< part of the pending window already looked at [ns]
  // Last data of the windows returned; kTimeMin before the first.
  TimeNs last_point_ = kTimeMin;
  TimeNs last_imu_ = kTimeMin,
         last_read_ = kTimeMin;  ///< any sample, and one of a gyro that is neither dead nor clipped
  TimeNs unread_until_ = kTimeMin;
  double imu_time_ = 0;       ///< of the intervals between samples of late, without gaps [ns]
  double imu_intervals_ = 0;  ///< their number
};

}  // namespace aslio::plugins
