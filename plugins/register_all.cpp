#include "register_all.hpp"

#include "aslio/stages/estimator.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

// One function per family, defined in <family>/register.cpp.
void register_windows(plugin::Registry<WindowStrategy>& registry);
void register_overlaps(plugin::Registry<OverlapMetric>& registry);
void register_stores(plugin::Registry<OccupancyStore>& registry);
void register_maps(plugin::Registry<Map>& registry);
void register_estimators(plugin::Registry<Estimator>& registry);
void register_motions(plugin::Registry<MotionModel>& registry);
void register_residuals(plugin::Registry<Residual>& registry);
void register_samplers(plugin::Registry<Sampler>& registry);
void register_histories(plugin::Registry<HistoryPolicy>& registry);
void register_insertions(plugin::Registry<Insertion>& registry);

namespace {
template <class S>
void add(plugin::Catalog& catalog, void (*register_family)(plugin::Registry<S>&)) {
  plugin::Registry<S> registry(catalog);
  register_family(registry);
}
}  // namespace

void register_all(plugin::Catalog& catalog) {
  add(catalog, register_windows);
  add(catalog, register_overlaps);
  add(catalog, register_stores);
  add(catalog, register_maps);
  add(catalog, register_estimators);
  add(catalog, register_motions);
  add(catalog, register_residuals);
  add(catalog, register_samplers);
  add(catalog, register_histories);
  add(catalog, register_insertions);
}

}  // namespace aslio::plugins
