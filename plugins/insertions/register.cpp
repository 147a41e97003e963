#include "aslio/plugin/registry.hpp"
#include "aslio/stages/insertion.hpp"

namespace aslio::plugins {

void register_insertions(plugin::Registry<Insertion>& registry);

void register_insertions(plugin::Registry<Insertion>& registry) { (void)registry; }

}  // namespace aslio::plugins
