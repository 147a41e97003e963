#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"

namespace my_plugin {

/// What enters the map, and when? Here: all points of an update whose correction was small; after a large one the
/// points were placed too doubtfully to be kept. The contract stands in aslio/stages/insertion.hpp.
class MyStage final : public aslio::Insertion {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    double max_correction = 0.3;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  aslio::InsertCount apply(const aslio::Window& window, const aslio::Update& update, aslio::Map& map) override;

 private:
  double max_correction_;  ///< [m]
};

}  // namespace my_plugin
