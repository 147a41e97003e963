#pragma once

#include <vector>

#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

/// Where the points of the last updates belong by what later updates have found (docs/equations.md IESKF-12): the IMU
/// knows the motion of a tenth of a second better than a single update does, so poses before a window's end are those
/// that lead to its corrected pose and velocity by the motion that was measured. Places are in W [m], times in ns.
class CarriedPoints final : public PointRevision {
 public:
  /// Room for the updates of half a second at 125 Hz, five times what the shipped windows reach back over.
  CarriedPoints() { slices_.reserve(64); }

  void clear() {
    slices_.clear();
    settled_ = 0;
  }
  /// Points of `t` or before are not asked for any more.
  void forget(TimeNs t);
  /// After an update, whose points are where it placed them: those before them have moved by its correction, if it has
  /// accepted one, stay where they are from now on, when the update is not finite, or are forgotten with the
  /// map.
  void follow(const Update& update, const WindowPlan& plan);
  /// Moves all points by the correction of the state at prior.t, which is after them, but those that have settled.
  void correct(const NavState& prior, const NavState& posterior);
  /// From now on points of (begin, end] are known. Pre: begin is not before the last end.
  void append(TimeNs begin, TimeNs end) { slices_.push_back({.begin = begin, .end = end}); }

  /// A point of time t that its own update placed at p_W. With the same `hint` (0 at first) for all, points in the
  /// order of time are found fastest.
  Vec3 place(TimeNs t, const Vec3& p_W, std::size_t& hint) const {
    if (hint >= slices_.size() || t <= slices_[hint].begin) hint = 0;
    while (hint < slices_.size() && slices_[hint].end < t) ++hint;
    if (hint == slices_.size() || t <= slices_[hint].begin) return p_W;
    const Slice& slice = slices_[hint];
    return slice.turn * p_W + slice.shift + to_seconds(t - slice.end) * slice.drift;
  }
  Vec3 place(const WorldPoint& point) const override {
    std::size_t oldest = 0;
    return place(point.t, point.p_W, oldest);
  }

 private:
  /// Fresh points of one update, and all corrections since: p -> turn p + shift + drift (t - end) [m, m/s, s].
  struct Slice {
    TimeNs begin = 0, end = 0;
    Mat3 turn = Mat3::Identity();
    Vec3 shift = Vec3::Zero(), drift = Vec3::Zero();
  };
  std::vector<Slice> slices_;  ///< in time order
  std::size_t settled_ = 0;    ///< of them, from the oldest on: later corrections say nothing of them
};

}  // namespace aslio::plugins
