#include "aslio/plugin/registry.hpp"
#include "windows/fixed.hpp"
#include "windows/sod_adaptive.hpp"

namespace aslio::plugins {

void register_windows(plugin::Registry<WindowStrategy>& registry);

void register_windows(plugin::Registry<WindowStrategy>& registry) {
  registry.add<FixedWindow>("fixed", "an update every period, or at the end of every sweep");
  registry.add<SodAdaptiveWindow>("sod_adaptive", "updates that come faster as the spatial overlap falls (AS-LIO)");
}

}  // namespace aslio::plugins
