#include "aslio/plugin/registry.hpp"
#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

void register_estimators(plugin::Registry<Estimator>& registry);

void register_estimators(plugin::Registry<Estimator>& registry) { (void)registry; }

}  // namespace aslio::plugins
