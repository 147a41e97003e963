#pragma once
/// `fixed`: an update every period, or at the end of every sweep; the baseline of every comparison.

#include <optional>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::plugins {

class FixedWindow final : public WindowStrategy {
 public:
  /// Where a window ends.
  enum class Cut : std::uint8_t { time, sweep };

  struct Params {
    double period = 0.1;
    Cut cut = Cut::time;
    std::optional<double> frame_length = std::nullopt;
    double warmup = 0.0;
  };
  static void describe(config::Binder& b, Params& p);

  FixedWindow(const Params& params, const BuildContext& context);

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override;

 private:
  TimeNs period_;
  TimeNs frame_length_;
  TimeNs warmup_;
  Cut cut_;
};

}  // namespace aslio::plugins
