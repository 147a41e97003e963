#pragma once
/// `replay`: updates at the times a file says, whatever the data. Moved or shuffled it is the yoked control of an
/// adaptive window: as many updates, of the same durations, at the wrong moments. (WIN-7)
/// Beyond the end of the schedule an update comes every `period`, without history.

#include <string>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"
#include "windows/replay_schedule.hpp"

namespace aslio::plugins {

class ReplayWindow final : public WindowStrategy {
 public:
  struct Params {
    std::string file;
    double shift = 0.0;
    bool shuffle = false;
    std::int64_t seed = 1;
    double period = 0.1;
  };
  static void describe(config::Binder& b, Params& p);

  /// Throws ConfigError and DataError as ReplaySchedule::read().
  ReplayWindow(const Params& params, const BuildContext& context);

  /// Throws DataError at the first call when the schedule ends before the data begin, or begins long after.
  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override;
  TimeNs reach() const override { return reach_; }

 private:
  void check_begin(TimeNs begin);

  std::string file_;
  ReplaySchedule schedule_;
  TimeNs period_;
  TimeNs reach_;  ///< longest history of any update [ns]
  bool begun_ = false;
};

}  // namespace aslio::plugins
