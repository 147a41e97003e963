// `my_window`: a fixed period that shortens while the carrier turns.
#include <algorithm>
#include <optional>

#include "aslio/config/binder.hpp"
#include "aslio/plugin/entry.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/window.hpp"

namespace {

using namespace aslio;

class MyWindow final : public WindowStrategy {
 public:
  struct Params {
    double period = 0.1;
    double turning_period = 0.05;
    double turn_rate = 1.0;
  };

  static void describe(config::Binder& b, Params& p) {
    b.real("period", p.period, "s", {.min = 0.001, .max = 10.0}, "time between updates");
    b.real("turning_period", p.turning_period, "s", {.min = 0.001, .max = 10.0}, "the same while turning");
    b.real("turn_rate", p.turn_rate, "rad/s", {.above = 0.0}, "turning is a rate above this in the last window");
    b.require(p.turning_period <= p.period, "turning_period", "must not exceed period");
  }

  MyWindow(const Params& params, const BuildContext&)
      : period_(to_ns(params.period)), turning_period_(to_ns(params.turning_period)), turn_rate_(params.turn_rate) {}

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) override {
    const TimeNs begin = feedback.t;
    TimeNs end = begin + (turned(stream, begin) ? turning_period_ : period_);
    if (stream.points_until() < end || stream.imu_until() < end) return std::nullopt;
    WindowPlan plan;
    // Once the source has ended, what is left makes a shorter last window.
    if (stream.points_until() == kTimeMax && stream.last_point() < end) {
      if (stream.last_point() <= begin) return std::nullopt;
      end = stream.last_point();
      plan.partial = true;
    }
    plan.history_begin = plan.fresh_begin = begin;
    plan.end = end;
    return plan;
  }

  TimeNs reach() const override { return period_; }

 private:
  bool turned(const StreamView& stream, TimeNs t) const {
    const auto samples = stream.imu(t - period_, t);
    return std::any_of(samples.begin(), samples.end(),
                       [&](const ImuSample& sample) { return sample.gyro.norm() > turn_rate_; });
  }

  TimeNs period_, turning_period_;
  double turn_rate_;
};

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<WindowStrategy>(catalog).add<MyWindow>("my_window", "a period that shortens while turning");
}

}  // namespace

ASLIO_PLUGIN(register_types)
