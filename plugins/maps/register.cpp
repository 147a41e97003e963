#include "aslio/plugin/registry.hpp"
#include "aslio/stages/map.hpp"

namespace aslio::plugins {

void register_maps(plugin::Registry<Map>& registry);

void register_maps(plugin::Registry<Map>& registry) { (void)registry; }

}  // namespace aslio::plugins
