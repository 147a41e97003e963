#include "aslio/plugin/registry.hpp"
#include "aslio/stages/history.hpp"

namespace aslio::plugins {

void register_histories(plugin::Registry<HistoryPolicy>& registry);

void register_histories(plugin::Registry<HistoryPolicy>& registry) { (void)registry; }

}  // namespace aslio::plugins
