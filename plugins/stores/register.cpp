#include "aslio/plugin/registry.hpp"
#include "stores/block_hash.hpp"
#include "stores/flat_hash.hpp"
#include "stores/nested_hash.hpp"

namespace aslio::plugins {

void register_stores(plugin::Registry<OccupancyStore>& registry);

void register_stores(plugin::Registry<OccupancyStore>& registry) {
  registry.add<BlockHash>("block_hash", "Bricks of 8^3 bits, dilated when asked; the fastest and smallest.");
  registry.add<FlatHash>("flat_hash", "Packed cells in one open-addressing table, searched shell by shell.");
  registry.add<NestedHash>("nested_hash", "Hash of x to y to z, as in the paper (AS-LIO).");
}

}  // namespace aslio::plugins
