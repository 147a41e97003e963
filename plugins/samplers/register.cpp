#include "aslio/plugin/registry.hpp"
#include "aslio/stages/sampler.hpp"

namespace aslio::plugins {

void register_samplers(plugin::Registry<Sampler>& registry);

void register_samplers(plugin::Registry<Sampler>& registry) { (void)registry; }

}  // namespace aslio::plugins
