#include "insertions/keyframe.hpp"

namespace aslio::plugins {

void InsertKeyframe::describe(config::Binder& b, Params& p) {
  b.real("distance", p.distance, "m", {.min = 0.0, .max = 1000.0}, "motion since the last keyframe that makes one");
  b.real("turn", p.turn, "rad", {.min = 0.0, .max = 3.2}, "turn since the last keyframe that makes one");
}

InsertCount InsertKeyframe::apply(const Window& window, const Update& update, Map& map) {
  const Pose pose = update.state.pose();
  // An empty map holds the run up: without points (a covered lens) the first window was no keyframe.
  const bool enough = !begun_ || map.size() == 0 || update.restart_map ||
                      (pose.p - last_.p).norm() >= params_.distance ||
                      log_so3(last_.R.transpose() * pose.R).norm() >= params_.turn;
  if (!enough) return {update.points(PointUse::map).size(), 0};
  begun_ = true;
  last_ = pose;
  return map.insert(update.points(PointUse::map), window.sequence);
}

}  // namespace aslio::plugins
