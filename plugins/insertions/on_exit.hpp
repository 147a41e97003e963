#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"
#include "insertions/window_points.hpp"

namespace aslio::plugins {

/// `on_exit`: a fresh point of the map use enters the map when it leaves the window, once, where its own update placed
/// it, or where the estimator holds it by then (Update::revision), and under the stamp of that update: before the first
/// update whose window begins at its time or later. So no point of a window ever meets itself or its neighbours in
/// time, and the map lags by a window; where windows are no longer than their fresh interval, it is that of `on_new`.
///
/// What enters once is what `on_new` inserts: the points of updates that were not refused. Those of a refused update
/// are in no map, whatever comes later; those that were already waiting still enter at their time. A gap in the data
/// moves the window on as data would, so all that waited enters before the first update behind it. What is inside the
/// last window enters at the end of the stream. When the map starts again, waiting points are dropped as those in the
/// map are, and the points of that update enter at once, so that the next one has a map.
class InsertOnExit final : public Insertion {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}

  InsertOnExit(const Params&, const BuildContext&) {}

  InsertCount begin(const Window& window, Map& map) override { return insert(window.plan.history_begin, map); }
  InsertCount apply(const Window& window, const Update& update, Map& map) override {
    revision_ = update.revision;
    if (update.restart_map) {
      waiting_.clear();
      return map.insert(update.points(PointUse::map), window.sequence);
    }
    waiting_.append(update.points(PointUse::map), window.sequence);
    return {};
  }
  void finish(Map& map) override { insert(kTimeMax, map); }

 private:
  InsertCount insert(TimeNs until, Map& map) {
    InsertCount count;
    waiting_.leave(until, [&](std::span<const WorldPoint> points, std::uint32_t sequence) {
      const InsertCount part = map.insert(revised(points), sequence);
      count.offered += part.offered;
      count.inserted += part.inserted;
    });
    return count;
  }

  std::span<const WorldPoint> revised(std::span<const WorldPoint> points) {
    if (revision_ == nullptr) return points;
    revised_.assign(points.begin(), points.end());
    for (WorldPoint& point : revised_) point.p_W = revision_->place(point);
    return revised_;
  }

  WindowPoints waiting_;
  const PointRevision* revision_ = nullptr;
  std::vector<WorldPoint> revised_;
};

}  // namespace aslio::plugins
