#include "aslio/plugin/registry.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

void register_overlaps(plugin::Registry<OverlapMetric>& registry);

void register_overlaps(plugin::Registry<OverlapMetric>& registry) { (void)registry; }

}  // namespace aslio::plugins
