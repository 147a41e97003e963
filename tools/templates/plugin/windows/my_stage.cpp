#include "my_stage.hpp"

#include <algorithm>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.real("period", p.period, "s", {.min = 0.001, .max = 10.0}, "time between updates");
  b.real("turning_period", p.turning_period, "s", {.min = 0.001, .max = 10.0}, "the same while turning");
  b.real("turn_rate", p.turn_rate, "rad/s", {.above = 0.0}, "turning is a rate above this in the last period");
  b.require(p.turning_period <= p.period, "turning_period", "must not exceed period");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : period_(to_ns(params.period)), turning_period_(to_ns(params.turning_period)), turn_rate_(params.turn_rate) {
  (void)context;
}

std::optional<WindowPlan> MyStage::next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) {
  (void)probe;  // overlap of the coming points at the predicted pose, for strategies that look ahead
  const TimeNs begin = feedback.t;
  TimeNs end = begin + (turned(stream, begin) ? turning_period_ : period_);
  // Over a gap of the sensor the window grows by whole periods: each window has points.
  while (stream.points_until() >= end && stream.last_point() > end && stream.points(begin, end).empty()) end += period_;
  if (stream.points_until() < end || stream.imu_until() < end) return std::nullopt;
  WindowPlan plan;
  // Once the source has ended, what is left makes a shorter last window.
  if (stream.points_until() == kTimeMax && stream.last_point() < end) {
    if (stream.last_point() <= begin) return std::nullopt;
    end = stream.last_point();
    plan.partial = true;
  }
  // An earlier history_begin keeps old points in the window (reach() must allow it).
  plan.history_begin = plan.fresh_begin = begin;
  plan.end = end;
  return plan;
}

bool MyStage::turned(const StreamView& stream, TimeNs t) const {
  const auto samples = stream.imu(t - period_, t);
  return std::any_of(samples.begin(), samples.end(),
                     [&](const ImuSample& sample) { return sample.gyro.norm() > turn_rate_; });
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<WindowStrategy>(catalog).add<MyStage>("my_stage", "A period that shortens while turning.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
