#include "aslio/core/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio {

namespace {

void require_finite(const StampedPose& pose, std::size_t index) {
  if (pose.T.R.allFinite() && pose.T.p.allFinite()) return;
  throw DataError(
      fmt::format("trajectory: pose {} at t = {} ns is not finite; remove it, or cut the trajectory before it diverged",
                  index, pose.t));
}

void require_later(TimeNs previous, const StampedPose& pose, std::size_t index) {
  if (pose.t > previous) return;
  throw DataError(
      fmt::format("trajectory: pose {} at t = {} ns is not later than the one before it at t = {} ns; sort the poses "
                  "by time and remove duplicates",
                  index, pose.t, previous));
}

}  // namespace

Trajectory::Trajectory(std::vector<StampedPose> poses) : poses_(std::move(poses)) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    require_finite(poses_[i], i);
    if (i > 0) require_later(poses_[i - 1].t, poses_[i], i);
  }
}

void Trajectory::append(const StampedPose& pose) {
  require_finite(pose, poses_.size());
  if (!poses_.empty()) require_later(poses_.back().t, pose, poses_.size());
  poses_.push_back(pose);
}

std::optional<Pose> Trajectory::pose(TimeNs t) const { return pose(t, kTimeMax); }

std::optional<Pose> Trajectory::pose(TimeNs t, TimeNs max_gap) const {
  const auto next = std::lower_bound(poses_.begin(), poses_.end(), t,
                                     [](const StampedPose& sample, TimeNs time) { return sample.t < time; });
  if (next == poses_.end()) return std::nullopt;
  if (next->t == t) return next->T;  // a sample needs no neighbour
  if (next == poses_.begin()) return std::nullopt;
  const StampedPose& before = *(next - 1);
  const TimeNs gap = next->t - before.t;
  if (gap > max_gap) return std::nullopt;
  return interpolate(before.T, next->T, static_cast<double>(t - before.t) / static_cast<double>(gap));
}

double Trajectory::path_length() const {
  double length = 0.0;
  for (std::size_t i = 1; i < poses_.size(); ++i) length += (poses_[i].T.p - poses_[i - 1].T.p).norm();
  return length;
}

}  // namespace aslio
