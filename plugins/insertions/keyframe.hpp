#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"

namespace aslio::plugins {

/// `keyframe`: fresh points enter the map at their own update, if it stands far enough from the last one that did
/// (LIO-SAM). The first one enters always.
class InsertKeyframe final : public Insertion {
 public:
  struct Params {
    double distance = 1.0;
    double turn = 0.2;
  };
  static void describe(config::Binder& b, Params& p);

  InsertKeyframe(const Params& params, const BuildContext&) : params_(params) {}

  InsertCount apply(const Window& window, const Update& update, Map& map) override;

 private:
  Params params_;
  bool begun_ = false;
  Pose last_;
};

}  // namespace aslio::plugins
