#include "aslio/config/binder.hpp"
#include "aslio/pipeline/odometry.hpp"

namespace aslio::pipeline {

void PipelineConfig::describe(config::Binder& b, PipelineConfig& p) {
  b.stage("window", p.window, "when the next update is, and over which points");
  b.stage("overlap", p.overlap, "how much of the frame the map already knows");
  b.stage("history", p.history, "what old points of the window are worth");
  b.stages("samplers", p.samplers, "which points take part: a chain, in this order");
  b.stage("map", p.map, "nearest neighbours around a point");
  b.stage("insertion", p.insertion, "what enters the map, and when");
  b.stage("estimator", p.estimator, "the state, given all that");
  b.group("initialisation", p.initialisation, "where the first state comes from");
  b.group("range_noise", p.range_noise, "which noise of ranges the lengths of the stages were chosen for");
  b.real("max_speed", p.limits.max_speed, "m/s", {.above = 0}, "a faster state has diverged");
  b.real("max_silence", p.limits.max_silence, "s", {.above = 0, .max = 1e6},
         "so has a run without an accepted update for longer than this");
  b.real("max_gap", p.limits.max_gap, "s", {.above = 0, .max = 1e6},
         "and one without points, or between two IMU samples, for longer than this");
  b.choice("when_lost", p.when_lost,
           {{"restart", PipelineConfig::WhenLost::restart}, {"end", PipelineConfig::WhenLost::end}},
           "a run that has diverged starts again with an empty map, from the last pose it knew, or ends");
}

}  // namespace aslio::pipeline
