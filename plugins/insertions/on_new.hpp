#pragma once
/// `on_new`: fresh points enter the map once, at their own update; history points never do.

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"

namespace aslio::plugins {

class InsertOnNew final : public Insertion {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}

  InsertOnNew(const Params&, const BuildContext&) {}

  InsertCount apply(const Window& window, const Update& update, Map& map) override {
    return map.insert(update.points(PointUse::map), window.sequence);
  }
};

}  // namespace aslio::plugins
