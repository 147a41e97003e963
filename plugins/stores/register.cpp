#include "aslio/plugin/registry.hpp"
#include "stores/flat_hash.hpp"

namespace aslio::plugins {

void register_stores(plugin::Registry<OccupancyStore>& registry);

void register_stores(plugin::Registry<OccupancyStore>& registry) {
  registry.add<FlatHash>("flat_hash", "Packed cells in one open-addressing table, searched shell by shell.");
}

}  // namespace aslio::plugins
