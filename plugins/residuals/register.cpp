#include "aslio/plugin/registry.hpp"
#include "aslio/stages/residual.hpp"

namespace aslio::plugins {

void register_residuals(plugin::Registry<Residual>& registry);

void register_residuals(plugin::Registry<Residual>& registry) { (void)registry; }

}  // namespace aslio::plugins
