#pragma once
/// `imu_rate`: the stronger the motion the IMU measures within a frame, the more sub-frames of equal duration it is cut
/// into (after FR-LIO, whose abstract names the idea but not the rule). (WIN-6)

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::plugins {

class ImuRateWindow final : public WindowStrategy {
 public:
  /// What becomes of the sub-frames.
  enum class Emit : std::uint8_t {
    updates,  ///< each is the fresh interval of an update of its own
    cuts      ///< one update per frame, which names their ends: for an estimator that smooths over them
  };

  struct Params {
    double frame_length = 0.1;
    double rate_unit_deg = 85.9437;
    double acc_unit = 4.0;
    std::int64_t n_max = 8;
    Emit emit = Emit::updates;
  };
  static void describe(config::Binder& b, Params& p);

  ImuRateWindow(const Params& params, const BuildContext& context);

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override { return frame_length_; }
  bool gives_cuts() const override { return emit_ == Emit::cuts; }
  bool decides_by_imu() const override { return true; }

 private:
  double intensity(const StreamView& stream, TimeNs begin, const NavState& from) const;
  TimeNs part_end(std::int64_t part) const { return frame_begin_ + frame_length_ * part / parts_; }
  void cut(WindowPlan& plan) const;

  TimeNs frame_length_;
  double rate_unit_;  ///< [rad/s]
  double acc_unit_;   ///< [m/s^2]
  std::int64_t n_max_;
  Emit emit_;
  // The frame that is being cut.
  TimeNs frame_begin_ = 0;
  std::int64_t parts_ = 1;
  std::int64_t part_ = 0;       ///< sub-frames of it handed out; `parts_` once it is done
  TimeNs expected_ = kTimeMin;  ///< end of the last one as wanted: elsewhere, a gap came between
};

}  // namespace aslio::plugins
