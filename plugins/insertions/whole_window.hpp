#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"
#include "insertions/window_points.hpp"

namespace aslio::plugins {

/// `whole_window`: every update inserts all points of its window again, as SR-LIO does with its reconstructed sweep:
/// the fresh ones, and before them the old ones moved along with the correction of this update (eq. INS-1), all under
/// its stamp. Meant for a map that refuses points too near to others; any other one holds each point once per window
/// that saw it. Where windows are no longer than their fresh interval, the map is that of `on_new`. Neither points of
/// updates that were not accepted nor those before them are part of later windows.
class InsertWholeWindow final : public Insertion {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}

  InsertWholeWindow(const Params&, const BuildContext&) {}

  InsertCount apply(const Window& window, const Update& update, Map& map) override;

 private:
  WindowPoints window_;
  std::uint32_t last_ = 0;  ///< sequence of the window that entered last
  std::vector<WorldPoint> placed_;
};

}  // namespace aslio::plugins
