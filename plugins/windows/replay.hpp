#pragma once
/// `replay`: updates at the times a file says, whatever the data. Moved or put into another order it is the yoked
/// control of an adaptive window: as many updates, at the wrong moments, at a steady rate, or where the gyro turns.
/// (WIN-7) Beyond the end of the schedule an update comes every `period`, without history.

#include <string>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"
#include "windows/replay_schedule.hpp"

namespace aslio::plugins {

class ReplayWindow final : public WindowStrategy {
 public:
  enum class Order { recorded, shuffled, steady, turn_rate };
  struct Params {
    std::string file;
    double shift = 0.0;
    Order order = Order::recorded;
    std::int64_t seed = 1;
    double warmup = 1.0;
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
  TimeNs history_begin_ = kTimeMin;  ///< of the last plan
  TimeNs period_;
  TimeNs reach_;  ///< longest history of any update [ns]
  bool begun_ = false;
  bool anew_ = false;
};

}  // namespace aslio::plugins
