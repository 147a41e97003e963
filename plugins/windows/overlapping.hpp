#pragma once
/// `overlapping`: windows of one length at a fixed step shorter than it, as SR-LIO rebuilds its sweeps: each window is
/// the newest segment with the older ones of the same length before it. (WIN-4)

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::plugins {

class OverlappingWindow final : public WindowStrategy {
 public:
  struct Params {
    double length = 0.1;
    double step = 0.05;
  };
  static void describe(config::Binder& b, Params& p);

  OverlappingWindow(const Params& params, const BuildContext& context);

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override { return length_; }

 private:
  TimeNs length_;
  TimeNs step_;
};

}  // namespace aslio::plugins
