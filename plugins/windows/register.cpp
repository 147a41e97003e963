#include "aslio/plugin/registry.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::plugins {

void register_windows(plugin::Registry<WindowStrategy>& registry);

void register_windows(plugin::Registry<WindowStrategy>& registry) { (void)registry; }

}  // namespace aslio::plugins
