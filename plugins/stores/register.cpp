#include "aslio/plugin/registry.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

void register_stores(plugin::Registry<OccupancyStore>& registry);

void register_stores(plugin::Registry<OccupancyStore>& registry) { (void)registry; }

}  // namespace aslio::plugins
