#include "my_stage.hpp"

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.real("max_correction", p.max_correction, "m", {.above = 0.0},
         "distance from prior to posterior position above which the points of an update stay out of the map");
}

MyStage::MyStage(const Params& params, const BuildContext& context) : max_correction_(params.max_correction) {
  (void)context;
}

InsertCount MyStage::apply(const Window& window, const Update& update, Map& map) {
  const auto points = update.points(PointUse::map);
  const double correction = (update.state.p - update.prior.p).norm();
  if (correction > max_correction_) return {.offered = points.size(), .inserted = 0};
  return map.insert(points, window.sequence);
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Insertion>(catalog).add<MyStage>("my_stage", "Points of updates whose correction was small.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
