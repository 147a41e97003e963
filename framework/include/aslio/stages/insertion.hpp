#pragma once
/// Insertions: what enters the map, and when?

#include "aslio/stages/estimator.hpp"

namespace aslio {

/// Contract. apply() is called once per update whose step was not refused, after the overlap has been measured.
class Insertion : public Stage {
 public:
  static constexpr std::string_view family = "insertions";
  virtual InsertCount apply(const Window& window, const Update& update, Map& map) = 0;
};

}  // namespace aslio
