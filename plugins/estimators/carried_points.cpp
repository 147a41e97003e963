#include "estimators/carried_points.hpp"

#include <algorithm>
#include <span>

namespace aslio::plugins {

void CarriedPoints::forget(TimeNs t) {
  const auto kept = std::find_if(slices_.begin(), slices_.end(), [t](const Slice& slice) { return slice.end > t; });
  settled_ -= std::min(settled_, static_cast<std::size_t>(kept - slices_.begin()));
  slices_.erase(slices_.begin(), kept);
}

void CarriedPoints::follow(const Update& update, const WindowPlan& plan) {
  if (update.restart_map) {
    clear();
  } else if (update.status == UpdateStatus::non_finite) {  // its motion cannot be relied on
    settled_ = slices_.size();
  } else if (update.accepted) {
    correct(update.prior, update.state);
  }
  append(plan.fresh_begin, plan.end);
}

/// eq. IESKF-12.
void CarriedPoints::correct(const NavState& prior, const NavState& posterior) {
  const Mat3 turn = posterior.R * prior.R.transpose();
  const Vec3 faster = posterior.v - turn * prior.v;  // the turn alone would turn the path behind, too
  for (Slice& slice : std::span(slices_).subspan(settled_)) {
    const double before = to_seconds(prior.t - slice.end);
    slice.turn = turn * slice.turn;
    slice.shift = turn * (slice.shift - prior.p) + posterior.p - before * faster;
    slice.drift = turn * slice.drift + faster;
  }
}

}  // namespace aslio::plugins
