#include "insertions/whole_window.hpp"

namespace aslio::plugins {

InsertCount InsertWholeWindow::apply(const Window& window, const Update& update, Map& map) {
  const bool follows = window.sequence == last_ + 1;  // else a refused step lies between, and poses may have drifted
  last_ = window.sequence;
  if (update.restart_map || !follows) {
    window_.clear();
  } else {
    window_.leave(window.plan.history_begin, [](std::span<const WorldPoint>, std::uint32_t) {});
  }
  const auto old = window_.inside(), fresh = update.points(PointUse::map);
  placed_.assign(old.begin(), old.end());
  if (update.revision != nullptr) {  // it knows better than this update's correction alone where they lie
    for (WorldPoint& point : placed_) point.p_W = update.revision->place(point);
  } else if (update.accepted) {
    const Pose correction = update.state.pose() * update.prior.pose().inverse();  // eq. INS-1
    for (WorldPoint& point : placed_) point.p_W = correction * point.p_W;
  }
  placed_.insert(placed_.end(), fresh.begin(), fresh.end());
  if (update.accepted || update.status == UpdateStatus::initialising) {
    window_.append(fresh, window.sequence);
  } else {  // dead reckoning alone may have drifted from the poses before and those to come
    window_.clear();
  }
  return map.insert(placed_, window.sequence);
}

}  // namespace aslio::plugins
