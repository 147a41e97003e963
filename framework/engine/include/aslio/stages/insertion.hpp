#pragma once
/// Insertions: what enters the map, and when? (docs/equations.md INS-1..)

#include "aslio/stages/estimator.hpp"

namespace aslio {

/// Contract. begin() is called once per window before its update; what leaves the window may enter the map there, since
/// neither history nor map would hold it during the update otherwise. apply() is called once per update whose
/// points may enter (Update::insert), after the overlap has been measured; if the map starts again with this update
/// (Update::restart_map) it has been cleared before, and what came earlier must not enter it any more. finish() is
/// called at the end of the stream. No others ever enter.
class Insertion : public Stage {
 public:
  static constexpr std::string_view family = "insertions";
  /// Whether it asks the map for nearest points, which a map of surfaces cannot answer.
  virtual bool needs_nearest_points() const { return false; }
  virtual InsertCount begin(const Window& window, Map& map) {
    (void)window, (void)map;
    return {};
  }
  virtual InsertCount apply(const Window& window, const Update& update, Map& map) = 0;
  virtual void finish(Map& map) { (void)map; }
};

}  // namespace aslio
