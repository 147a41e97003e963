#include "estimators/carried_points.hpp"

#include <algorithm>

namespace aslio::plugins {

void CarriedPoints::forget(TimeNs t) {
  const auto kept = std::find_if(slices_.begin(), slices_.end(), [t](const Slice& slice) { return slice.end > t; });
  slices_.erase(slices_.begin(), kept);
}

void CarriedPoints::follow(const Update& update, const WindowPlan& plan) {
  if (update.restart_map || update.status == UpdateStatus::non_finite) {  // nobody knows the motion of that window
    clear();
  } else if (update.accepted) {
    correct(update.prior, update.state);
  }
  append(plan.fresh_begin, plan.end);
}

/// eq. IESKF-12.
void CarriedPoints::correct(const NavState& prior, const NavState& posterior) {
  const Mat3 turn = posterior.R * prior.R.transpose();
  const Vec3 faster = posterior.v - turn * prior.v;  // the turn alone would turn the path behind, too
  for (Slice& slice : slices_) {
    const double before = to_seconds(prior.t - slice.end);
    slice.turn = turn * slice.turn;
    slice.shift = turn * (slice.shift - prior.p) + posterior.p - before * faster;
    slice.drift = turn * slice.drift + faster;
  }
}

}  // namespace aslio::plugins
